#include "baton/record/report.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "baton/record/json.hpp"
#include "baton/record/trace.hpp"

namespace baton {
namespace {

nlohmann::json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

}  // namespace

Report::Report(const RobotModel& robot) : robot_(&robot), kinematics_(robot), commands_(robot), tracking_(robot) {
  kinematics_.set(Eigen::Map<const VecX>(robot.mj().qpos0, robot.nq()));
}

void Report::on_tick(const TickRecord& record) {
  const Navigator& nav = record.navigator;
  duration_ = record.t + robot_->profile().tick.period;
  tick_.add(record.tick_us);
  if (record.truth != nullptr) kinematics_.set(record.truth->q);
  commands_.add(record, kinematics_);
  segments_.add(nav, kinematics_.com());
  note_sensors(nav);
  note_heat(nav);
  has_truth_ = record.truth != nullptr;
  if (!has_truth_) return;
  const Truth& truth = *record.truth;
  fallen_ = fallen_ || truth.fallen;
  tilt_ = std::max(tilt_, tilt_of(kinematics_.trunk().R));
  note_zmp_margin(truth);
  if (nav.phase() != Phase::fallen && !truth.fallen) tracking_.add(record, kinematics_);
  note_height(nav);
}

void Report::on_plan(const PlanRecord& record) {
  if (std::holds_alternative<std::monostate>(record.answer.outcome)) return;
  plan_.add(record.plan_us);
  commands_.answered(record.request);
}

void Report::note_sensors(const Navigator& navigator) {
  for (const Sensor sensor : kSensors)
    sensors_[sensor].rejected += navigator.sensors().health(sensor) == Health::good ? 0 : 1;
  for (const Event& event : navigator.events()) {
    const auto* changed = std::get_if<SensorChanged>(&event);
    if (changed != nullptr && changed->health == Health::lost) ++sensors_[changed->sensor].lost;
  }
}

void Report::note_heat(const Navigator& navigator) {
  const Hottest now = navigator.thermometer().hottest();
  if (now.total > heat_.most.total) heat_.most = now;
  heat_.hot += navigator.thermometer().hot() ? 1 : 0;
  const auto* changed = find_event<HeatChanged>(navigator.events());
  heat_.times += changed != nullptr && changed->hot ? 1 : 0;
}

void Report::note_zmp_margin(const Truth& truth) {
  if (!truth.touch.left && !truth.touch.right) return;
  const BySide<Pose> sole{kinematics_.sole(Side::left), kinematics_.sole(Side::right)};
  const double height = support_plane(sole, truth.touch);
  const double margin =
      support_polygon(*robot_, sole, truth.touch, kinematics_.com(), height).margin(measured_zmp(truth, height));
  zmp_margin_ = std::min(zmp_margin_, margin);
}

void Report::note_height(const Navigator& navigator) {
  const bool rested = std::exchange(height_.rests, navigator.phase() == Phase::hold);
  const BySide<bool>& contact = navigator.sample().contact;
  if (!contact.left || !contact.right) return;
  if (height_.rests) {
    const double ground = 0.5 * (kinematics_.sole(Side::left).p.z() + kinematics_.sole(Side::right).p.z());
    height_.last = kinematics_.com().z() - ground;
  } else if (rested && height_.first == 0.0) {
    height_.first = height_.last;
  }
}

nlohmann::json Report::json(const std::string& world, const std::string& on, long seed, double wall) const {
  nlohmann::json final = {{"com", vector_json(kinematics_.com())}};
  for (const Part part : kParts) {
    const Pose pose = part == Part::trunk ? kinematics_.trunk() : guided_pose(kinematics_, part);
    final[std::string(to_string(part))] = {{"p", vector_json(pose.p)}, {"rpy", vector_json(rpy_of(pose.R))}};
  }
  nlohmann::json sensors = nlohmann::json::object();
  for (const Sensor sensor : kSensors) {
    const SensorCount& count = sensors_[sensor];
    if (count.rejected == 0) continue;
    sensors[std::string(to_string(sensor))] = {{"rejected_ticks", count.rejected}, {"lost", count.lost}};
  }
  nlohmann::json heat = nullptr;
  if (heat_.most.joint >= 0) {
    heat = {{"most", heat_.most.total},
            {"joint", robot_->joints()[static_cast<std::size_t>(heat_.most.joint)].name},
            {"hot_s", static_cast<double>(heat_.hot) * robot_->profile().tick.period},
            {"hot_times", heat_.times}};
  }
  nlohmann::json report = {
      {"robot", robot_->profile().name},
      {"world", world},
      {"on", on},
      {"seed", seed},
      {"duration_s", duration_},
      {"falls", fallen_ ? 1 : 0},
      {"segments", segments_.json()},
      {"commands", commands_.json()},
      {"travel_m", segments_.travel(kinematics_.com())},
      {"sensors", std::move(sensors)},
      {"heat", std::move(heat)},
      {"plan_us", plan_.summary()},
      {"tick_us", tick_.summary()},
      {"zmp_margin_m",
       {{"planned_min", finite_or_null(segments_.zmp_margin())}, {"measured_min", finite_or_null(zmp_margin_)}}},
      {"tracking", tracking_.json()},
      {"com_height_m", {{"first", height_.first}, {"last", height_.last}}},
      {"tilt_deg_max", tilt_ * 180.0 / M_PI},
      {"real_time_factor", wall > 0.0 ? duration_ / wall : 0.0},
      {"final", final}};
  if (has_truth_) return report;
  for (const char* key : {"falls", "travel_m", "tracking", "com_height_m", "tilt_deg_max", "final"})
    report[key] = nullptr;
  report["commands"]["moved"] = nullptr;
  return report;
}

}  // namespace baton
