/// Ends the maker's own gait, which commands the same motors: asks the robot's motion switcher which one is active, has
/// it released, and asks again, until there is none. No network and no clock of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace baton::unitree {

class FactoryGait {
 public:
  enum class State { asking, released, failed };
  enum class Api : std::int64_t { check_mode = 1001, release_mode = 1003 };

  struct Request {
    std::int64_t id = 0;
    Api api = Api::check_mode;
  };

  struct Parameters {
    double answering = 1.0;  ///< time for an answer [s]
    double releasing = 1.0;  ///< time from a release until it is asked again [s]
    int questions = 5;       ///< without a proper answer in a row, after which it fails
    int releases = 5;        ///< after which it fails if the gait is still there
  };

  /// @param first_id of the requests; each has the next one
  explicit FactoryGait(std::int64_t first_id) : FactoryGait(first_id, Parameters()) {}
  FactoryGait(std::int64_t first_id, const Parameters& parameters) : parameters_(parameters), id_(first_id) {}

  /// What is to be sent at time `t` [s], if anything.
  [[nodiscard]] std::optional<Request> next(double t);
  /// An answer has come. Those of requests of others are ignored.
  /// @param code 0: done
  /// @param data of `check_mode`: JSON with the gait's `name`, "" for none
  void answer(std::int64_t id, int code, const std::string& data, double t);

  [[nodiscard]] State state() const { return state_; }
  /// Name of the gait that was active; "": none was, as far as is known.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Why it failed: one line.
  [[nodiscard]] const std::string& why() const { return why_; }

 private:
  /// The last request came to nothing.
  void in_vain(const std::string& why, double t);

  Parameters parameters_;
  State state_ = State::asking;
  std::int64_t id_;           ///< of the next request
  Api api_{Api::check_mode};  ///< of the next request, or of the one that is sent
  bool waiting_ = false;      ///< for an answer to the request before `id_`
  double due_ = 0.0;          ///< when the next request is sent, or the answer must have come [s]
  int in_vain_ = 0;           ///< requests in a row
  int releases_ = 0;
  std::string name_, why_;
};

}  // namespace baton::unitree
