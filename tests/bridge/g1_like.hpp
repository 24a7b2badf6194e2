/// A robot with the joints of a Unitree G1, made here: the model of the real one is fetched, and is no part of this
/// repository.
#pragma once

#include "baton/model/robot_model.hpp"

namespace baton::test {

/// Loaded once a process. Its joints come in another order than the G1's motors.
const RobotModel& g1_like();

}  // namespace baton::test
