# Finds MuJoCo: the folder MUJOCO_ROOT (CMake or environment variable) if given, either a release
# (include/, lib/) or the folder of the Python package, else the `mujoco` Python package, whose wheel
# carries the headers and the library. Defines the target mujoco::mujoco and MuJoCo_VERSION.
include("${CMAKE_CURRENT_LIST_DIR}/PythonPackage.cmake")
include(FindPackageHandleStandardArgs)

set(_root "${MUJOCO_ROOT}")
if(NOT _root)
  set(_root "$ENV{MUJOCO_ROOT}")
endif()
if(NOT _root)
  baton_find_in_python_package(_root mujoco mujoco)
endif()

set(MuJoCo_INCLUDE_DIR "")
set(MuJoCo_LIBRARY "")
set(MuJoCo_VERSION "")
if(EXISTS "${_root}/include/mujoco/mujoco.h")
  set(MuJoCo_INCLUDE_DIR "${_root}/include")
  file(GLOB _libraries "${_root}/libmujoco.so.*" "${_root}/lib/libmujoco.so.*" "${_root}/lib/libmujoco.so")
  if(_libraries)
    list(GET _libraries 0 MuJoCo_LIBRARY)
    string(REGEX MATCH "[0-9]+\\.[0-9]+\\.[0-9]+$" MuJoCo_VERSION "${MuJoCo_LIBRARY}")
  endif()
endif()

find_package_handle_standard_args(
  MuJoCo
  REQUIRED_VARS MuJoCo_LIBRARY MuJoCo_INCLUDE_DIR
  VERSION_VAR MuJoCo_VERSION
  REASON_FAILURE_MESSAGE "run scripts/setup, or set MUJOCO_ROOT")

if(MuJoCo_FOUND AND NOT TARGET mujoco::mujoco)
  add_library(mujoco::mujoco SHARED IMPORTED)
  set_target_properties(
    mujoco::mujoco
    PROPERTIES IMPORTED_LOCATION "${MuJoCo_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${MuJoCo_INCLUDE_DIR}")
endif()
