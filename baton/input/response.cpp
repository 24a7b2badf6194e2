#include "baton/input/response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "baton/model/error.hpp"

namespace baton {

Response::Response(const Parameters& parameters) : parameters_(parameters) {
  const auto [d, c] = parameters;
  if (!(d >= 0.0 && d < 1.0)) {
    throw InputError(fmt::format("response: dead zone = {}: must be at least 0 and less than 1", d));
  }
  if (!(c >= 0.0 && c <= 1.0)) throw InputError(fmt::format("response: curve = {}: must be from 0 to 1", c));
}

double Response::operator()(double x) const {
  const auto [d, c] = parameters_;
  const double travel = std::min(std::abs(x), 1.0);
  if (!(travel > d)) return 0.0;
  const double u = (travel - d) / (1.0 - d);
  return std::copysign((1.0 - c) * u + c * u * u * u, x);
}

}  // namespace baton
