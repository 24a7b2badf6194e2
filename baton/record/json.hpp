/// Eigen vectors as JSON arrays.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <vector>

namespace baton {

template <typename Derived>
[[nodiscard]] nlohmann::json vector_json(const Eigen::PlainObjectBase<Derived>& v) {
  return std::vector<double>(v.data(), v.data() + v.size());
}

}  // namespace baton
