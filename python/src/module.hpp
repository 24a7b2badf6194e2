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
#include "baton/model/contact.hpp"
#include "baton/model/error.hpp"
#include "baton/model/mujoco.hpp"
#include "baton/model/robot_model.hpp"

namespace baton::python {

namespace nb = nanobind;

/// Lets other Python threads run, and keeps MuJoCo's warnings about our models to itself.
struct Away {
  nb::gil_scoped_release released;
  OwnMujoco own;
};
/// Back to Python, as when it is called from there.
struct Back {
  nb::gil_scoped_acquire acquired;
  OwnMujoco own{false};
};

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
    const nb::object asarray = nb::module_::import_("numpy").attr("asarray");
    array = asarray(given);
    const auto kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
    if (std::string("biuf").find(kind) == std::string::npos)
      throw InputError(fmt::format("{} {}: must be numbers", name, nb::repr(given).c_str()));
    array = asarray(array, nb::arg("dtype") = "float64");
  } catch (const nb::python_error& error) {
    if (!error.matches(PyExc_TypeError) && !error.matches(PyExc_ValueError)) throw;
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
  nb::object path;
  try {
    path = nb::module_::import_("os").attr("fspath")(given);
  } catch (const nb::python_error& error) {
    if (!error.matches(PyExc_TypeError)) throw;
  }
  std::string text;
  if (!path.is_valid() || !nb::try_cast(path, text) || text.find('\0') != std::string::npos)
    throw InputError(fmt::format("{} {}: must be a name or a file", what, nb::repr(given).c_str()));
  return text;
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
