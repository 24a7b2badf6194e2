/// Dead zone and curve: from the raw position of a stick to an axis of a command.
#pragma once

namespace baton {

/// x ↦ sign(x) ((1 − c) u + c u³) with u = (|x| − d)/(1 − d), and 0 for |x| ≤ d: odd, continuous, rising, ±1
/// at the ends. Each axis on its own, so that a push along one axis stays on it.
class Response {
 public:
  struct Parameters {
    double dead_zone = 0.08;  ///< d: share of the travel that counts as centred, 0 … < 1
    double curve = 0.5;       ///< c: 0 straight … 1 cubic, for fine motion about the centre
  };

  Response() : Response(Parameters{}) {}
  /// @throws InputError a parameter is out of its range or not finite
  explicit Response(const Parameters& parameters);

  /// Any `x` is taken: beyond ±1 it is clamped, not a number counts as centred.
  [[nodiscard]] double operator()(double x) const;

 private:
  Parameters parameters_;
};

}  // namespace baton
