# Bridges to the networks of robots' makers: each a program of its own, which `baton bridge` starts.

# Unitree. What it decides, without its network:
file(GLOB unitree_sources CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/bridge/unitree/*.cpp")
set(unitree_network_sources "${CMAKE_SOURCE_DIR}/bridge/unitree/low_level.cpp"
                            "${CMAKE_SOURCE_DIR}/bridge/unitree/main.cpp"
                            "${CMAKE_SOURCE_DIR}/bridge/unitree/network.cpp")
list(REMOVE_ITEM unitree_sources ${unitree_network_sources})
add_library(baton_unitree STATIC ${unitree_sources})
compile_folders_as_one(baton_unitree)
target_link_libraries(
  baton_unitree
  PUBLIC baton
  PRIVATE nlohmann_json::nlohmann_json baton_options)

# The whole bridge, where Cyclone DDS and its compiler of message types (idlc) are.
find_package(CycloneDDS 0.10.2 QUIET)
find_program(IDLC idlc)
if(NOT CycloneDDS_FOUND OR NOT IDLC)
  message(STATUS "Cyclone DDS (cyclonedds-dev, cyclonedds-tools) is not there: without `baton bridge unitree`")
  return()
endif()
set(unitree_types "${CMAKE_BINARY_DIR}/unitree_types")
file(MAKE_DIRECTORY "${unitree_types}")
add_custom_command(
  OUTPUT "${unitree_types}/low_level.c" "${unitree_types}/low_level.h"
  COMMAND "${IDLC}" -o "${unitree_types}" "${CMAKE_SOURCE_DIR}/bridge/unitree/low_level.idl"
  DEPENDS bridge/unitree/low_level.idl
  WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}")
add_library(baton_unitree_types STATIC "${unitree_types}/low_level.c" "${unitree_types}/low_level.h")
target_include_directories(baton_unitree_types SYSTEM PUBLIC "${unitree_types}")
target_link_libraries(baton_unitree_types PUBLIC CycloneDDS::ddsc)

add_executable(baton_bridge_unitree ${unitree_network_sources})
set_target_properties(baton_bridge_unitree PROPERTIES OUTPUT_NAME baton-bridge-unitree
                                                      RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}")
compile_folders_as_one(baton_bridge_unitree)
target_link_libraries(
  baton_bridge_unitree PRIVATE baton_unitree baton_unitree_types baton_link CLI11::CLI11 spdlog::spdlog
                               Threads::Threads baton_options)

# Who says on that network what a test tells it to.
if(BUILD_TESTING)
  add_executable(baton_unitree_wire tests/bridge/unitree_wire.cpp)
  set_target_properties(baton_unitree_wire PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}")
  target_link_libraries(baton_unitree_wire PRIVATE baton_unitree_types baton_options)
endif()
