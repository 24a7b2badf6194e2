#include "baton/bridge/rcss_names.hpp"

#include <fmt/format.h>

#include <map>

#include "baton/model/error.hpp"
#include "baton/model/mujoco.hpp"

namespace baton::bridge {
namespace {

constexpr std::string_view kMotor = "_tau";  ///< what the name of a joint's motor ends with

}  // namespace

RcssNames rcss_names(const RobotModel& robot) {
  const SpecPtr spec = parse_model(robot.profile().model);
  std::map<std::string, RcssJoint> by_joint;
  for (mjsElement* e = mjs_firstElement(spec.get(), mjOBJ_SENSOR); e != nullptr; e = mjs_nextElement(spec.get(), e)) {
    const mjsSensor& sensor = *mjs_asSensor(e);
    if (sensor.type == mjSENS_JOINTPOS)
      by_joint[mjs_getString(sensor.objname)].perceptor = mjs_getString(mjs_getName(e));
  }
  for (mjsElement* e = mjs_firstElement(spec.get(), mjOBJ_ACTUATOR); e != nullptr; e = mjs_nextElement(spec.get(), e)) {
    std::string name = mjs_getString(mjs_getName(e));
    if (!name.ends_with(kMotor)) continue;
    name.resize(name.size() - kMotor.size());
    by_joint[mjs_getString(mjs_asActuator(e)->target)].effector = name;
  }
  RcssNames names{mjs_getString(spec->modelname), {}};
  for (const Joint& joint : robot.joints()) {
    const RcssJoint& found = by_joint[joint.name];
    if (found.perceptor.empty() || found.effector.empty())
      throw InputError(fmt::format("{}: joint '{}' has no {} in {}: must be the simulator's own model, as rcss_k1 has",
                                   robot.profile().name, joint.name,
                                   found.perceptor.empty() ? "jointpos sensor" : "motor named …_tau",
                                   robot.profile().model.string()));
    names.joints.push_back(found);
  }
  return names;
}

}  // namespace baton::bridge
