# The Python module baton._core, and all else that the wheel has: pyproject.toml installs the component "python".
find_package(Python 3.11 REQUIRED COMPONENTS Interpreter Development.Module)
find_package(nanobind CONFIG REQUIRED)

file(GLOB module_sources CONFIGURE_DEPENDS python/src/*.cpp)
# Scenarios, and what they need.
list(
  APPEND
  module_sources
  baton/input/json_reader.cpp
  baton/input/script.cpp
  baton/proving/dice.cpp
  baton/proving/scenario.cpp
  baton/proving/stick.cpp)
nanobind_add_module(baton_core NB_STATIC ${module_sources})
set_target_properties(
  baton_core
  PROPERTIES OUTPUT_NAME _core
             # The wheels of MuJoCo and eiquadprog are installed beside baton.
             INSTALL_RPATH "$ORIGIN/../mujoco;$ORIGIN/../cmeel.prefix/lib")
target_include_directories(baton_core SYSTEM PRIVATE "${NB_DIR}/include")  # not held to our warnings
target_link_libraries(baton_core PRIVATE baton baton_planning_thread nlohmann_json::nlohmann_json baton_options)
nanobind_add_stub(
  baton_stub
  MODULE
  _core
  OUTPUT
  "${CMAKE_BINARY_DIR}/_core.pyi"
  PYTHON_PATH
  $<TARGET_FILE_DIR:baton_core>
  DEPENDS
  baton_core)

# What the licences of the libraries in the wheel ask for: those that auditwheel copies into it, as Debian states them,
# and headers that are compiled in.
foreach(library libassimp libdraco libfmt libminizip libpugixml libtomlplusplus libeigen3-dev nlohmann-json3-dev)
  file(GLOB copyright "/usr/share/doc/${library}*/copyright")
  if(copyright)
    list(GET copyright 0 copyright)
    install(FILES "${copyright}" DESTINATION baton/licences COMPONENT python RENAME ${library}.txt)
  endif()
endforeach()
file(GLOB nanobind_licence "${NB_DIR}/../nanobind-*.dist-info/licenses/LICENSE")
install(FILES ${nanobind_licence} DESTINATION baton/licences COMPONENT python RENAME nanobind.txt)

install(TARGETS baton_core DESTINATION baton COMPONENT python)
install(FILES "${CMAKE_BINARY_DIR}/_core.pyi" DESTINATION baton COMPONENT python)
install(
  DIRECTORY robots worlds
  DESTINATION baton/share
  COMPONENT python
  PATTERN model EXCLUDE)
