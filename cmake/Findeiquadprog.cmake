# Finds eiquadprog: under the prefix EIQUADPROG_ROOT (CMake or environment variable) if given, else in the
# `eiquadprog` Python package, whose wheel carries headers and library. Defines eiquadprog::eiquadprog.
# (The wheel's own CMake config also changes the C++ standard and more, so it is not used.)
include("${CMAKE_CURRENT_LIST_DIR}/PythonPackage.cmake")
include(CMakeFindDependencyMacro)
include(FindPackageHandleStandardArgs)

find_dependency(Eigen3)

set(_root "${EIQUADPROG_ROOT}")
if(NOT _root)
  set(_root "$ENV{EIQUADPROG_ROOT}")
endif()
if(NOT _root)
  baton_find_in_python_package(_root eiquadprog cmeel.prefix)
endif()

set(eiquadprog_INCLUDE_DIR "")
set(eiquadprog_LIBRARY "")
if(EXISTS "${_root}/include/eiquadprog/eiquadprog-fast.hpp" AND EXISTS "${_root}/lib/libeiquadprog.so")
  set(eiquadprog_INCLUDE_DIR "${_root}/include")
  set(eiquadprog_LIBRARY "${_root}/lib/libeiquadprog.so")
endif()

find_package_handle_standard_args(
  eiquadprog
  REQUIRED_VARS eiquadprog_LIBRARY eiquadprog_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "run scripts/setup, or set EIQUADPROG_ROOT")

if(eiquadprog_FOUND AND NOT TARGET eiquadprog::eiquadprog)
  add_library(eiquadprog::eiquadprog SHARED IMPORTED)
  set_target_properties(
    eiquadprog::eiquadprog
    PROPERTIES IMPORTED_LOCATION "${eiquadprog_LIBRARY}"
               INTERFACE_INCLUDE_DIRECTORIES "${eiquadprog_INCLUDE_DIR}"
               INTERFACE_LINK_LIBRARIES Eigen3::Eigen)
endif()
