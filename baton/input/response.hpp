/// Response curve with dead zone: raw stick position → command axis.
#pragma once

namespace baton {

/// x ↦ sign(x) ((1 − c) u + c u³) with u = (|x| − d)/(1 − d), and 0 for |x| ≤ d: odd, continuous, increasing, ±1 at the
/// ends. Applied to each axis separately, so that a deflection along one axis stays on it.
class Response {
 public:
  struct Parameters {
    double dead_zone = 0.08;  ///< d: fraction of travel that counts as centred, in [0, 1)
    double curve = 0.5;       ///< c: 0 linear … 1 cubic, for fine control near the centre
  };

  Response() : Response(Parameters{}) {}
  /// @throws InputError a parameter is out of range or not finite
  explicit Response(const Parameters& parameters);

  /// Accepts any `x`: clamped to ±1, NaN counts as centred.
  [[nodiscard]] double operator()(double x) const;

 private:
  Parameters parameters_;
};

}  // namespace baton
