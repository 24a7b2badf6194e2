/// The exception for bad input: a file, a key, an option or a value that the user can correct.
#pragma once

#include <stdexcept>

namespace baton {

/// Bad input. The message is one line that names the thing, the value, and what would be right.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace baton
