#include "baton/record/trace.hpp"

#include <fmt/format.h>

#include <iterator>
#include <limits>
#include <utility>

namespace baton {

Vec2 measured_zmp(const Truth& truth, double height) {
  const Wrench total{truth.sole.left.force + truth.sole.right.force, truth.sole.left.moment + truth.sole.right.moment};
  return total.zmp(height);
}

Trace::Trace(const RobotModel& robot, const std::filesystem::path& file, std::string what)
    : robot_(&robot), kinematics_(robot), file_(file), what_(std::move(what)), out_(open_stream(file, what_)) {
  std::string header = "t,guide,segment,phase";
  for (int i = 0; i < robot.nq(); ++i)
    header += fmt::format(",qpos_{}", i);
  for (int i = 0; i < robot.nv(); ++i)
    header += fmt::format(",qvel_{}", i);
  for (const Joint& joint : robot.joints())
    header += fmt::format(",target_{}", joint.name);
  header +=
      ",com_x,com_y,com_z,com_plan_x,com_plan_y,com_plan_z,zmp_x,zmp_y,zmp_plan_x,zmp_plan_y"
      ",contact_left,contact_right,touch_left,touch_right,force_left,force_right"
      ",dcm_error_x,dcm_error_y,intent\n";
  out_ << header;
}

void Trace::on_tick(const TickRecord& record) {
  const Navigator& nav = record.navigator;
  const MotionSample& plan = nav.sample();
  const Pose& anchor = nav.anchor();
  const Vec3 com_plan = anchor * plan.com;
  const Vec2 zmp = plan.zmp + nav.correction().com_offset;
  const Vec3 zmp_plan = anchor * Vec3(zmp.x(), zmp.y(), plan.zmp_height);

  const Truth* truth = record.truth;
  const Phase phase = truth != nullptr && truth->fallen ? Phase::fallen : nav.phase();
  fmt::memory_buffer row;
  const auto to = std::back_inserter(row);
  fmt::format_to(to, "{:.6f},{},{},{}", record.t, to_string(nav.command().guide), nav.segment(), to_string(phase));
  const auto numbers = [&](const auto& values) {
    for (const double value : values)
      fmt::format_to(to, ",{:.10g}", value);
  };
  const auto seen = [&](Eigen::Index count, const auto& values) {
    numbers(truth != nullptr ? VecX(values()) : VecX::Constant(count, std::numeric_limits<double>::quiet_NaN()));
  };
  if (truth != nullptr) kinematics_.set(truth->q);
  seen(robot_->nq(), [&] { return truth->q; });
  seen(robot_->nv(), [&] { return truth->dq; });
  numbers(record.target.q);
  seen(3, [&] { return kinematics_.com(); });
  numbers(com_plan);
  seen(2, [&] { return measured_zmp(*truth, zmp_plan.z()); });
  numbers(zmp_plan.head<2>());
  fmt::format_to(to, ",{:d},{:d}", plan.contact.left, plan.contact.right);
  seen(4, [&] {
    const BySide<Wrench>& sole = truth->sole;
    return Eigen::Vector4d(truth->touch.left, truth->touch.right, sole.left.force.z(), sole.right.force.z());
  });
  numbers(nav.dcm_error());
  fmt::format_to(to, ",{:d}\n", static_cast<int>(nav.purpose()));
  out_.write(row.data(), static_cast<std::streamsize>(row.size()));
}

}  // namespace baton
