/// Symbolic expressions: atoms and lists of them in round brackets, `(HJ (n q_llj1)(ax -12.5))`.
#pragma once

#include <stdexcept>
#include <string_view>
#include <vector>

namespace baton::bridge {

/// A text is no symbolic expression, or not the one that is expected. The message is one line.
class SExprError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An atom, or a list.
struct SExpr {
  std::string_view atom;      ///< in the text that was read; empty: a list
  std::vector<SExpr> list{};  ///< of an atom: empty

  /// Whether it is a list that begins with this atom.
  [[nodiscard]] bool is(std::string_view head) const { return !list.empty() && list.front().atom == head; }

  /// The element at an index.
  /// @throws SExprError there is none
  [[nodiscard]] const SExpr& at(std::size_t index) const;
  /// The atom as a finite number.
  /// @throws SExprError it is none
  [[nodiscard]] double number() const;
  /// The first element that is a list with this head.
  /// @throws SExprError there is none
  [[nodiscard]] const SExpr& find(std::string_view head) const;
};

/// The expressions of a text, one after the other. They refer to the text, which has to outlive them.
/// @throws SExprError brackets do not match, or are nested more than 32 deep
[[nodiscard]] std::vector<SExpr> parse_sexprs(std::string_view text);

}  // namespace baton::bridge
