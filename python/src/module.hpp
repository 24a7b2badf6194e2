/// The Python module `baton._core`: what its sources share.
#pragma once

// Types of nanobind must be known alike in all sources, so they all include these.
#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <fmt/format.h>

#include <memory>
#include <string>

#include "baton/guide/command.hpp"
#include "baton/model/error.hpp"
#include "baton/model/robot_model.hpp"

namespace baton::python {

namespace nb = nanobind;

/// A robot's model, shared by all of its runs.
struct Robot {
  std::shared_ptr<const RobotModel> model;
};

/// The part of that name.
/// @throws InputError no such part
[[nodiscard]] Part part_named(const std::string& name);

/// What a parameter `name` was given, as a vector or matrix: whatever NumPy makes an array of numbers of.
/// @throws InputError it is not, or has another shape
template <typename Matrix>
[[nodiscard]] Matrix numbers(const char* name, nb::handle given) {
  Matrix matrix;
  nb::object array;
  try {
    array = nb::module_::import_("numpy").attr("asarray")(given, nb::arg("dtype") = "float64");
  } catch (const nb::python_error&) {
    throw InputError(fmt::format("{} {}: must be numbers", name, nb::repr(given).c_str()));
  }
  if (!nb::try_cast(array, matrix)) {
    const std::string shape = Matrix::ColsAtCompileTime > 1
                                  ? fmt::format("({}, {})", Matrix::RowsAtCompileTime, Matrix::ColsAtCompileTime)
                              : Matrix::RowsAtCompileTime > 0 ? fmt::format("({},)", Matrix::RowsAtCompileTime)
                                                              : "(n,)";
    throw InputError(
        fmt::format("{} has the shape {}; must be {}", name, nb::repr(array.attr("shape")).c_str(), shape));
  }
  return matrix;
}

/// A name, or a path-like object as text.
/// @throws InputError neither
[[nodiscard]] inline std::string name_or_path(const char* what, nb::handle given) {
  nb::object text;
  try {
    text = nb::module_::import_("os").attr("fspath")(given);
  } catch (const nb::python_error&) {
  }
  if (!text.is_valid() || !nb::isinstance<nb::str>(text))
    throw InputError(fmt::format("{} {}: must be a name or a file", what, nb::repr(given).c_str()));
  return nb::cast<std::string>(text);
}

/// A robot, or what `Robot` is made of.
[[nodiscard]] Robot robot_of(nb::handle given);

/// Force and moment as one vector (6) [N, N·m].
[[nodiscard]] inline Vec6 vector_of(const Wrench& wrench) {
  return (Vec6() << wrench.force, wrench.moment).finished();
}

void bind_robot(nb::module_& m);
void bind_signals(nb::module_& m);
void bind_events(nb::module_& m);
void bind_run(nb::module_& m);

}  // namespace baton::python
