#include "app/view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "baton/model/contact.hpp"
#include "baton/model/kinematics.hpp"
#include "baton/record/trace.hpp"

namespace baton::app {
namespace {

constexpr double kSlipShows = 2.0;  ///< time that a slip is shown to the operator [s]
constexpr double kShows = 0.2;      ///< time off the plan before the operator is told [s]

/// Names of the lost sensors, separated by commas.
std::string lost_sensors(const SensorCheck& sensors) {
  std::string names;
  for (const Sensor sensor : kSensors) {
    if (sensors.health(sensor) == Health::lost)
      names += fmt::format("{}{}", names.empty() ? "" : ", ", to_string(sensor));
  }
  return names;
}

/// The robot as it is estimated: what can be shown of one without truth.
Truth estimated(const Session& session) {
  const Navigator& nav = session.navigator();
  const Pose& anchor = nav.anchor();
  const Eigen::Vector4d w = nav.state().q.segment<4>(3);
  Truth seen;
  seen.t = session.t();
  seen.q = nav.state().q;
  set_root(seen.q, anchor * Pose{seen.q.head<3>(), Eigen::Quaterniond(w[0], w[1], w[2], w[3]).toRotationMatrix()});
  for (const Side side : kSides) {
    const Wrench& wrench = nav.state().force[side];
    const Vec3 force = anchor.R * wrench.force;
    seen.sole[side] = {force, anchor.R * wrench.moment + (anchor * nav.state().sole[side].p).cross(force)};
  }
  return seen;
}

}  // namespace

std::string heat_message(const Session& session) {
  const Thermometer& thermometer = session.navigator().thermometer();
  if (!thermometer.hot()) return "";
  const Hottest hottest = thermometer.hottest();
  std::string joint = session.model().joints()[static_cast<std::size_t>(hottest.joint)].name;
  std::replace(joint.begin(), joint.end(), '_', ' ');
  return fmt::format("A motor is hot ({}, {:.0f} % of what it may be): no new motion until it has cooled down.", joint,
                     1e2 * hottest.total);
}

std::string arms_message(const Session& session) {
  const Refusal* why = session.navigator().arms_refusal();
  if (why == nullptr) return "";
  std::string where = place(*why).empty() ? "" : fmt::format(" ({})", place(*why));
  std::replace(where.begin(), where.end(), '_', ' ');
  return fmt::format("The arms cannot follow their targets, or only in part: {}{}.", info(why->reason).text, where);
}

View::View(const Simulation& simulation, int port, bool damps)
    : damps_(damps),
      scene_(compile_text(simulation.model_text(), "scene")),
      data_(mj_makeData(scene_.get())),
      cockpit_(
          [&] {
            Cockpit::Parameters parameters;
            parameters.port = port;
            parameters.page = share_dir() / "web" / "dist";
            return parameters;
          }(),
          simulation.session().model(), simulation.session().world().name(), *scene_) {}

void View::show(const Simulation& simulation, const DeviceStatus& device, const Refusals& refusals,
                const std::string& notice) {
  const Session& session = simulation.session();
  const Navigator& nav = session.navigator();
  if (find_event<Committed>(nav.events()) != nullptr) segment_start_ = session.t();
  if (find_event<Slipped>(nav.events()) != nullptr) slipped_ = session.t();
  if (session.t() - shown_ < 1.0 / 30.0 && !session.fallen()) return;
  shown_ = session.t();

  const Truth truth = session.truth() != nullptr ? *session.truth() : estimated(session);
  mju_copy(data_->qpos, truth.q.data(), scene_->nq);
  mj_kinematics(scene_.get(), data_.get());
  mj_comPos(scene_.get(), data_.get());
  const Pose& anchor = nav.anchor();
  const MotionSample& plan = nav.sample();
  Frame frame;
  frame.t = session.t();
  frame.bodies = body_poses(*scene_, *data_);
  frame.command = nav.command();
  frame.device = device;
  if (nav.motion() != nullptr) {
    Goal goal = nav.motion()->goal;
    goal.com = anchor * goal.com;
    goal.trunk = anchor.R * goal.trunk;
    for (const Side side : kSides) {
      goal.sole[side] = anchor * goal.sole[side];
      if (goal.hand[side]) goal.hand[side] = anchor * *goal.hand[side];
    }
    frame.segment.goal = std::move(goal);
    frame.segment.time = session.t() - segment_start_;
    frame.segment.duration = nav.motion()->duration();
    frame.segment.limit = nav.planned()->limit;
  }
  frame.history = nav.history();
  frame.balance.contact = plan.contact;
  const BySide<Pose> sole{anchor * plan.sole.left, anchor * plan.sole.right};
  frame.balance.support_height = plan.zmp_height + anchor.p.z();
  frame.balance.support =
      support_polygon(session.model(), sole, plan.contact, anchor * plan.com, frame.balance.support_height);
  frame.balance.com = Eigen::Map<const Vec3>(data_->subtree_com);
  frame.balance.zmp = measured_zmp(truth, frame.balance.support_height);
  frame.balance.dcm = (anchor * nav.state().dcm(session.model().omega())).head<2>();
  frame.refusal = refusals.newest();
  frame.refusals = refusals.count();
  frame.stuck = refusals.stuck();
  frame.activity = activity(nav, session.fallen());
  frame.damps = damps_;
  if (!nav.disturbed()) {
    steady_ = session.t();
    caught_ = nav.caught();
  }
  if (frame.activity == Activity::fallen) {
    frame.message = "The robot fell: " + truth.fall + ".";
  } else if (nav.guard() == Guard::fallen) {
    frame.message = "The robot has fallen, by its sensors: its motors give no torque. Stand it up on both feet.";
  } else if (nav.guard() == Guard::stood_up) {
    frame.message = "The robot stands upright again: release the stick, and it goes on.";
  } else if (nav.guard() == Guard::lifted) {
    frame.message = "Lifted off the ground. Continues once it stands again and the stick has been released.";
  } else if (session.t() < slipped_ + kSlipShows) {
    frame.message =
        fmt::format("A sole slipped by {:.0f} mm. The robot continues from here, but cannot retrace past this point.",
                    1e3 * nav.last_slip());
  } else if (nav.sensors().lost()) {
    frame.message =
        fmt::format("No usable readings: {}. No new motion until they are back.", lost_sensors(nav.sensors()));
  } else if (nav.disturbed() && nav.caught() > caught_) {
    frame.message = "Pushed: taking a step to recover.";
  } else if (session.t() - steady_ > kShows) {
    frame.message = "Pushed off the plan: no new motion until it has recovered.";
  }
  if (frame.message.empty()) frame.message = notice;
  if (frame.message.empty()) frame.message = heat_message(session);
  if (frame.message.empty()) frame.message = arms_message(session);
  cockpit_.publish(std::move(frame));
}

}  // namespace baton::app
