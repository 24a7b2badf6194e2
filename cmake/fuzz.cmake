# The fuzz targets of tests/fuzz, for libFuzzer: `make fuzz` builds and runs them. Of the sources only what reads files
# and messages is compiled, into a library of its own that has the sanitizers.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  message(FATAL_ERROR "BATON_FUZZ needs clang, which has libFuzzer; this is ${CMAKE_CXX_COMPILER_ID}. Use the preset: "
                      "cmake --preset fuzz")
endif()

module_sources(fuzzed_sources math model ik)
list(
  APPEND
  fuzzed_sources
  baton/bridge/rcss_message.cpp
  baton/bridge/sexpr.cpp
  baton/cockpit/protocol.cpp
  baton/guide/arm_trajectory.cpp
  baton/guide/command.cpp
  baton/input/arm_script.cpp
  baton/input/arm_targets_json.cpp
  baton/input/json_reader.cpp
  baton/input/script.cpp
  baton/link/message.cpp
  baton/mcap/format.cpp
  baton/mcap/reader.cpp
  baton/plan/retrace.cpp
  baton/record/motion_file.cpp
  baton/record/output_file.cpp
  baton/record/recording_channels.cpp
  baton/record/recording_reader.cpp
  baton/record/ros_messages.cpp
  baton/robot/calibration.cpp
  bridge/unitree/factory_gait.cpp
  bridge/unitree/joints.cpp
  bridge/unitree/messages.cpp
  bridge/unitree/motors.cpp
  bridge/unitree/reading.cpp
  bridge/unitree/remote.cpp
  tests/bridge/g1_like.cpp)
add_library(baton_fuzzed STATIC EXCLUDE_FROM_ALL ${fuzzed_sources})
target_compile_features(baton_fuzzed PUBLIC cxx_std_20)
target_include_directories(baton_fuzzed PUBLIC "${CMAKE_SOURCE_DIR}")
# Not recovered from: a finding ends the run. Eigen as in BATON_SANITIZE.
target_compile_options(baton_fuzzed PUBLIC -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all
                                           -fno-omit-frame-pointer -O1 -g1)
target_compile_definitions(baton_fuzzed PUBLIC EIGEN_MALLOC_ALREADY_ALIGNED=1)
target_link_libraries(
  baton_fuzzed
  PUBLIC Eigen3::Eigen
         mujoco::mujoco
         eiquadprog::eiquadprog
         fmt::fmt
         nlohmann_json::nlohmann_json
         tomlplusplus::tomlplusplus
         pugixml::pugixml
         PkgConfig::Zstd
         ZLIB::ZLIB
         assimp::assimp
  PRIVATE baton_options)

add_custom_target(fuzz)
foreach(target script arms calibration profile urdf page recording motion link rcss unitree)
  add_executable(fuzz_${target} EXCLUDE_FROM_ALL tests/fuzz/fuzz_${target}.cpp)
  set_target_properties(fuzz_${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}")
  target_link_libraries(fuzz_${target} PRIVATE baton_fuzzed baton_options)
  target_link_options(fuzz_${target} PRIVATE -fsanitize=fuzzer,address,undefined)
  add_dependencies(fuzz fuzz_${target})
endforeach()
