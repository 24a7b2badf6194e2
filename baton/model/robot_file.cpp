#include "baton/model/robot_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <Eigen/Geometry>

#include "baton/model/error.hpp"
#include "baton/model/urdf.hpp"

namespace baton {
namespace {

namespace fs = std::filesystem;

constexpr int kRobotContype = 2;  ///< the robot's geoms: they touch what has the bit 1, so not each other

std::string name_of(mjsElement* element) {
  return mjs_getString(mjs_getName(element));
}

std::vector<mjsElement*> all(mjSpec& spec, mjtObj type) {
  std::vector<mjsElement*> elements;
  for (mjsElement* e = mjs_firstElement(&spec, type); e != nullptr; e = mjs_nextElement(&spec, e))
    elements.push_back(e);
  return elements;
}

std::vector<mjsElement*> children(mjsBody* body, mjtObj type, bool recurse) {
  std::vector<mjsElement*> elements;
  const int deep = recurse ? 1 : 0;
  for (mjsElement* e = mjs_firstChild(body, type, deep); e != nullptr; e = mjs_nextChild(body, e, deep))
    elements.push_back(e);
  return elements;
}

void make_absolute(mjString* file, const fs::path& folder) {
  const std::string given = mjs_getString(file);
  if (given.empty() || fs::path(given).is_absolute()) return;
  mjs_setString(file, (folder / given).c_str());
}

void make_assets_absolute(mjSpec& spec, const fs::path& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  const fs::path meshes = folder / mjs_getString(spec.compiler.meshdir);
  const fs::path textures = folder / mjs_getString(spec.compiler.texturedir);
  for (mjsElement* e : all(spec, mjOBJ_MESH))
    make_absolute(mjs_asMesh(e)->file, meshes);
  for (mjsElement* e : all(spec, mjOBJ_HFIELD))
    make_absolute(mjs_asHField(e)->file, meshes);
  for (mjsElement* e : all(spec, mjOBJ_TEXTURE))
    make_absolute(mjs_asTexture(e)->file, textures);
  for (mjsElement* e : all(spec, mjOBJ_MESH)) {  // a mesh without a name is named after its file
    const fs::path from = mjs_getString(mjs_asMesh(e)->file);
    if (name_of(e).empty() && !from.empty()) mjs_setName(e, from.stem().c_str());
  }
}

bool has_free_joint(mjsBody* body) {
  const auto joints = children(body, mjOBJ_JOINT, false);
  return std::ranges::any_of(joints, [](mjsElement* e) { return mjs_asJoint(e)->type == mjJNT_FREE; });
}

bool has_hinges(mjsBody* body) {
  const auto joints = children(body, mjOBJ_JOINT, true);
  return std::ranges::any_of(joints, [](mjsElement* e) { return mjs_asJoint(e)->type == mjJNT_HINGE; });
}

/// The robot's first body. Drops all else in the world of the file.
/// @return whether something was changed
bool isolate_robot(mjSpec& spec, const std::string& owner, mjsBody*& root) {
  mjsBody* world = mjs_findBody(&spec, "world");
  std::vector<mjsBody*> bodies;
  for (mjsElement* e : children(world, mjOBJ_BODY, false))
    bodies.push_back(mjs_asBody(e));
  auto found = std::ranges::find_if(bodies, [](mjsBody* b) { return has_free_joint(b) && has_hinges(b); });
  if (found == bodies.end()) found = std::ranges::find_if(bodies, has_hinges);
  if (found == bodies.end()) throw InputError(fmt::format("{}: no body has hinges: not a robot", owner));
  root = *found;
  if (name_of(root->element).empty()) mjs_setName(root->element, "robot");
  bool changed = false;
  for (mjsBody* body : bodies) {
    if (body == root) continue;
    mjs_delete(&spec, body->element);
    changed = true;
  }
  for (const mjtObj type : {mjOBJ_GEOM, mjOBJ_LIGHT}) {
    for (mjsElement* e : children(world, type, false)) {
      mjs_delete(&spec, e);
      changed = true;
    }
  }
  // What refers to what was dropped.
  for (mjsElement* e : all(spec, mjOBJ_PAIR)) {
    const mjsPair& pair = *mjs_asPair(e);
    const auto is_there = [&spec](mjString* name) {
      return mjs_findElement(&spec, mjOBJ_GEOM, mjs_getString(name)) != nullptr;
    };
    if (changed && (!is_there(pair.geomname1) || !is_there(pair.geomname2))) mjs_delete(&spec, e);
  }
  for (mjsElement* e : all(spec, mjOBJ_EXCLUDE)) {
    const mjsExclude& exclude = *mjs_asExclude(e);
    const auto is_there = [&spec](mjString* name) { return mjs_findBody(&spec, mjs_getString(name)) != nullptr; };
    if (changed && (!is_there(exclude.bodyname1) || !is_there(exclude.bodyname2))) mjs_delete(&spec, e);
  }
  for (mjsElement* e : all(spec, mjOBJ_CAMERA)) {
    if (changed) mjs_delete(&spec, e);
  }
  if (!has_free_joint(root)) {
    if (mjs_firstChild(root, mjOBJ_JOINT, 0) != nullptr) {
      throw InputError(
          fmt::format("{}: the first body with hinges, '{}', is held in the world by a joint of its own: a "
                      "robot that walks is free",
                      owner, name_of(root->element)));
    }
    mjs_addFreeJoint(root);
    changed = true;
  }
  return changed;
}

bool collides(const mjsGeom& geom) {
  return geom.contype != 0 || geom.conaffinity != 0;
}

/// Names what has no name: for messages, and to find it again in a world.
void name_everything(mjsBody* body) {
  const std::string owner = name_of(body->element);
  int count = 0;
  for (mjsElement* e : children(body, mjOBJ_JOINT, false)) {
    if (name_of(e).empty() && mjs_asJoint(e)->type != mjJNT_FREE)
      mjs_setName(e, fmt::format("{}_joint{}", owner, count).c_str());
    ++count;
  }
  count = 0;
  for (mjsElement* e : children(body, mjOBJ_GEOM, false)) {
    if (name_of(e).empty() && collides(*mjs_asGeom(e)))
      mjs_setName(e, fmt::format("{}_collider{}", owner, count).c_str());
    ++count;
  }
  count = 0;
  for (mjsElement* e : children(body, mjOBJ_BODY, false)) {
    if (name_of(e).empty()) mjs_setName(e, fmt::format("{}_link{}", owner, count).c_str());
    ++count;
    name_everything(mjs_asBody(e));
  }
}

/// Makes the named joints, and those that an equality makes follow others, rigid.
bool make_rigid(mjSpec& spec, const std::vector<std::string>& names) {
  std::set<std::string> rigid(names.begin(), names.end());
  bool changed = false;
  for (mjsElement* e : all(spec, mjOBJ_EQUALITY)) {
    const mjsEquality& equality = *mjs_asEquality(e);
    if (equality.type == mjEQ_JOINT && equality.active) rigid.insert(mjs_getString(equality.name1));
    mjs_delete(&spec, e);
    changed = true;
  }
  for (mjsElement* e : all(spec, mjOBJ_JOINT)) {
    if (mjs_asJoint(e)->type == mjJNT_FREE || rigid.erase(name_of(e)) == 0) continue;
    mjs_delete(&spec, e);
    changed = true;
  }
  for (const std::string& name : names) {
    if (rigid.contains(name)) throw InputError(fmt::format("rigid: the model has no hinge '{}'", name));
  }
  return changed;
}

bool is_torque_motor(const mjsActuator& actuator) {
  return actuator.trntype == mjTRN_JOINT && actuator.gaintype == mjGAIN_FIXED && actuator.biastype == mjBIAS_NONE &&
         actuator.dyntype == mjDYN_NONE && actuator.gear[0] == 1.0 && actuator.gainprm[0] == 1.0;
}

bool limited(mjtLimited flag, const double* range) {
  return flag == mjLIMITED_TRUE || (flag == mjLIMITED_AUTO && range[0] < range[1]);
}

/// The least of the torque limits that the model states for a joint; infinite without any [N·m].
double stated_torque(const mjsJoint& joint, const std::vector<mjsElement*>& actuators) {
  double stall = std::numeric_limits<double>::infinity();
  const auto narrow = [&stall](mjtLimited flag, const double* range, double gear) {
    if (!limited(flag, range)) return;
    stall = std::min(stall, std::min(std::abs(range[0]), std::abs(range[1])) * std::abs(gear));
  };
  narrow(joint.actfrclimited, joint.actfrcrange, 1.0);
  for (mjsElement* e : actuators) {
    const mjsActuator& actuator = *mjs_asActuator(e);
    if (actuator.trntype != mjTRN_JOINT || name_of(joint.element) != mjs_getString(actuator.target)) continue;
    const double gear = actuator.gear[0];
    narrow(actuator.forcelimited, actuator.forcerange, gear);
    if (actuator.gaintype == mjGAIN_FIXED && actuator.biastype == mjBIAS_NONE) {
      narrow(actuator.ctrllimited, actuator.ctrlrange, gear * actuator.gainprm[0]);
    }
  }
  return stall;
}

/// One torque motor at each hinge.
bool motorise(mjSpec& spec, const ModelChanges& changes) {
  const auto actuators = all(spec, mjOBJ_ACTUATOR);
  std::vector<mjsElement*> hinges = all(spec, mjOBJ_JOINT);
  std::erase_if(hinges, [](mjsElement* e) { return mjs_asJoint(e)->type != mjJNT_HINGE; });
  bool done = actuators.size() == hinges.size();
  for (mjsElement* e : actuators)
    done = done && is_torque_motor(*mjs_asActuator(e));
  for (mjsElement* e : hinges) {
    mjsJoint& joint = *mjs_asJoint(e);
    const auto change = changes.motors.find(name_of(e));
    if (change == changes.motors.end()) continue;
    if (change->second.armature > 0.0) joint.armature = change->second.armature;
    if (change->second.torque > 0.0 && change->second.torque != stated_torque(joint, actuators)) done = false;
  }
  if (done) return false;
  std::vector<double> stall;
  for (mjsElement* e : hinges) {
    const auto change = changes.motors.find(name_of(e));
    const bool given = change != changes.motors.end() && change->second.torque > 0.0;
    stall.push_back(given ? change->second.torque : stated_torque(*mjs_asJoint(e), actuators));
  }
  for (mjsElement* e : actuators)
    mjs_delete(&spec, e);
  for (std::size_t j = 0; j < hinges.size(); ++j) {
    const std::string name = name_of(hinges[j]);
    mjsActuator* motor = mjs_addActuator(&spec, nullptr);
    mjs_setToMotor(motor);
    mjs_setName(motor->element, name.c_str());
    motor->trntype = mjTRN_JOINT;
    mjs_setString(motor->target, name.c_str());
    mjsJoint& joint = *mjs_asJoint(hinges[j]);
    const bool finite = std::isfinite(stall[j]);
    motor->ctrllimited = joint.actfrclimited = finite ? mjLIMITED_TRUE : mjLIMITED_FALSE;
    for (const int end : {0, 1})
      motor->ctrlrange[end] = joint.actfrcrange[end] = finite ? (end == 0 ? -stall[j] : stall[j]) : 0.0;
  }
  return true;
}

/// The robot's geoms touch the world's but not each other's, except for pairs.
bool separate(mjSpec& spec, const ModelChanges& changes) {
  int type = 0;
  int affinity = 0;
  for (mjsElement* e : all(spec, mjOBJ_GEOM)) {
    type |= mjs_asGeom(e)->contype;
    affinity |= mjs_asGeom(e)->conaffinity;
  }
  bool changed = false;
  if ((type & affinity) != 0) {
    changed = true;
    for (mjsElement* e : all(spec, mjOBJ_GEOM)) {
      mjsGeom& geom = *mjs_asGeom(e);
      if (!collides(geom)) continue;
      geom.contype = kRobotContype;
      geom.conaffinity = 1;
    }
    for (mjsElement* e : all(spec, mjOBJ_EXCLUDE))
      mjs_delete(&spec, e);
  }
  if (!changes.self_pairs.empty()) {
    changed = true;
    for (mjsElement* e : all(spec, mjOBJ_PAIR))
      mjs_delete(&spec, e);
  }
  for (const auto& [a, b] : changes.self_pairs) {
    mjsPair* pair = mjs_addPair(&spec, nullptr);
    mjs_setString(pair->geomname1, a.c_str());
    mjs_setString(pair->geomname2, b.c_str());
  }
  return changed;
}

/// Deletes geoms that touch nothing, except where they make a body's inertia, and meshes that nothing uses then.
void drop_visuals(mjSpec& spec) {
  std::set<std::string> paired;
  for (mjsElement* e : all(spec, mjOBJ_PAIR)) {
    paired.insert(mjs_getString(mjs_asPair(e)->geomname1));
    paired.insert(mjs_getString(mjs_asPair(e)->geomname2));
  }
  std::set<std::string> used;
  for (mjsElement* e : all(spec, mjOBJ_GEOM)) {
    const mjsGeom& geom = *mjs_asGeom(e);
    const bool weighs =
        mjs_getCompiler(e)->inertiafromgeom == mjINERTIAFROMGEOM_TRUE || !mjs_getParent(e)->explicitinertial;
    if (collides(geom) || weighs || paired.contains(name_of(e))) {
      used.insert(mjs_getString(geom.meshname));
    } else {
      mjs_delete(&spec, e);
    }
  }
  for (mjsElement* e : all(spec, mjOBJ_MESH)) {
    if (!used.contains(name_of(e))) mjs_delete(&spec, e);
  }
}

Eigen::Quaterniond rotation(const double* quat, const mjsOrientation& alt, mjsElement* element) {
  std::array<double, 4> q{quat[0], quat[1], quat[2], quat[3]};
  if (alt.type != mjORIENTATION_QUAT) {
    const mjsCompiler* compiler = mjs_getCompiler(element);
    mjs_resolveOrientation(q.data(), compiler->degree, compiler->eulerseq, &alt);
  }
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
}

/// Attitude of a body in the root's frame at q = 0.
Eigen::Quaterniond attitude(mjsBody* body, mjsBody* root) {
  if (body == root) return Eigen::Quaterniond::Identity();
  Eigen::Quaterniond in_parent = rotation(body->quat, body->alt, body->element);
  for (mjsFrame* frame = mjs_getFrame(body->element); frame != nullptr; frame = mjs_getFrame(frame->element))
    in_parent = rotation(frame->quat, frame->alt, frame->element) * in_parent;
  return attitude(mjs_getParent(body->element), root) * in_parent;
}

/// A site at each named body that has none of its name, parallel to the root at q = 0.
bool add_sites(mjSpec& spec, mjsBody* root, const std::vector<std::string>& names, bool at_com) {
  bool changed = false;
  for (const std::string& name : names) {
    if (name.empty() || mjs_findElement(&spec, mjOBJ_SITE, name.c_str()) != nullptr) continue;
    mjsBody* body = mjs_findBody(&spec, name.c_str());
    if (body == nullptr || body == mjs_findBody(&spec, "world")) continue;  // whoever looks for it complains
    mjsSite* site = mjs_addSite(body, nullptr);
    mjs_setName(site->element, name.c_str());
    const Eigen::Quaterniond back = attitude(body, root).inverse();
    const std::array<double, 4> quat{back.w(), back.x(), back.y(), back.z()};
    std::copy(quat.begin(), quat.end(), site->quat);
    if (at_com && body->explicitinertial) std::copy_n(body->ipos, 3, site->pos);
    changed = true;
  }
  return changed;
}

}  // namespace

SpecPtr read_robot(const fs::path& file, const ModelChanges& changes, Visuals visuals) {
  const auto lock = lock_compiler();
  SpecPtr spec = is_urdf(file) ? parse_urdf(file) : parse_model(file);
  const std::string owner = fmt::format("model {}", file.string());
  make_assets_absolute(*spec, file);
  mjsBody* root = nullptr;
  bool changed = isolate_robot(*spec, owner, root);
  name_everything(root);
  changed |= make_rigid(*spec, changes.rigid);
  changed |= motorise(*spec, changes);
  changed |= separate(*spec, changes);
  changed |= add_sites(*spec, root, changes.sites, false);
  changed |= add_sites(*spec, root, changes.hands, true);
  if (visuals == Visuals::drop) drop_visuals(*spec);
  if (!changed) return spec;
  for (const mjtObj type : {mjOBJ_KEY, mjOBJ_SENSOR, mjOBJ_TENDON}) {
    for (mjsElement* e : all(*spec, type))
      mjs_delete(spec.get(), e);
  }
  return spec;
}

}  // namespace baton
