#include "baton/record/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "baton/guide/guide.hpp"
#include "baton/record/json.hpp"
#include "baton/record/trace.hpp"

namespace baton {
namespace {

constexpr double kMovedShare = 0.25;
constexpr double kMoved = 0.005;  ///< [m]

nlohmann::json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

/// The part of `made` along what was asked for; 0 if nothing was.
double along(const Vec3& asked, const Vec3& made) {
  return asked.isZero(0.0) ? 0.0 : asked.dot(made) / asked.norm();
}

}  // namespace

nlohmann::json Durations::summary() const {
  std::vector<double> sorted = us_;
  std::sort(sorted.begin(), sorted.end());
  const auto quantile = [&](double share) {
    if (sorted.empty()) return 0.0;
    return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
  };
  return {{"p50", quantile(0.5)},
          {"p99", quantile(0.99)},
          {"max", sorted.empty() ? 0.0 : sorted.back()},
          {"n", sorted.size()}};
}

bool Report::Interval::moved() const {
  const double wanted = asked.norm();
  const double wanted_rotation = asked_rotation.norm();
  return (wanted > 0.0 && (most >= kMovedShare * wanted || most >= kMoved)) ||
         (wanted_rotation > 0.0 && most_rotation >= kMovedShare * wanted_rotation);
}

Report::Report(const RobotModel& robot) : robot_(&robot), kinematics_(robot), planned_(robot) {}

Pose Report::guided_pose(Part part) {
  if (is_foot(part)) return kinematics_.sole(side_of(part));
  if (is_hand(part)) return kinematics_.hand(side_of(part));
  return {kinematics_.com(), kinematics_.trunk().R};
}

std::optional<Report::Interval> Report::asked(const Command& command, bool lifts, const Mat3& heading) const {
  const Profile& profile = robot_->profile();
  if (command.recall != Recall::none || command.neutral() || (command.axes.isZero(0.0) && !lifts)) return std::nullopt;
  const bool is_a_foot = is_foot(command.guide);
  const double size = is_a_foot                ? profile.reach.foot
                      : is_hand(command.guide) ? profile.reach.hand
                                               : profile.reach.trunk;
  Vec3 move = command.axes.head<3>() * size;
  Vec3 turn = command.axes.tail<3>() * profile.reach.rotation;
  if (is_a_foot) {
    const double lift = command.lift[side_of(command.guide)];
    move.z() = lift < Guide::kLeastLift ? 0.0 : lift * profile.swing.lift;
    turn.head<2>().setZero();
  }
  if (is_hand(command.guide) && !robot_->hand_has_attitude(side_of(command.guide))) turn.setZero();
  if (move.isZero(0.0) && turn.isZero(0.0)) return std::nullopt;
  Interval interval;
  interval.command = command;
  interval.asked = heading * move;
  interval.asked_rotation = heading * turn;
  return interval;
}

void Report::account(const Credit& credit, bool over) {
  Interval& interval = commands_[credit.command];
  const Pose now = guided_pose(interval.command.guide);
  const double made = interval.made + along(interval.asked, now.p - credit.start.p);
  const double rotation =
      interval.made_rotation + along(interval.asked_rotation, rotation_error(now.R, credit.start.R));
  interval.most = std::max(interval.most, made);
  interval.most_rotation = std::max(interval.most_rotation, rotation);
  if (!over) return;
  interval.made = made;
  interval.made_rotation = rotation;
}

void Report::on_tick(const TickRecord& record) {
  const Navigator& nav = record.navigator;
  duration_ = record.t + robot_->profile().tick.period;
  tick_.add(record.tick_us);
  if (record.truth != nullptr) kinematics_.set(record.truth->q);

  const Command& command = nav.command();
  if (!(command == last_command_)) {
    last_refused_.clear();
    // A throttle that only stays up asks for nothing new.
    const bool lifts =
        is_foot(command.guide) && command.lift[side_of(command.guide)] != last_command_.lift[side_of(command.guide)];
    const Mat3 heading = nav.anchor().R * rotation_z(mean_yaw(nav.sample().sole));
    const std::optional<Interval> interval = asked(command, lifts, heading);
    if (interval) commands_.push_back(*interval);
    command_ = interval ? static_cast<long>(commands_.size()) - 1 : -1;
    last_command_ = command;
  }

  caught_ = nav.caught();
  slips_ = nav.slips();
  const bool begins = nav.segment() != segment_ && nav.motion() != nullptr;
  std::erase_if(open_, [&](const Credit& credit) {
    const bool again = begins && static_cast<long>(credit.command) == planned_by_;
    const bool over = again || record.t >= credit.until - 0.5 * robot_->profile().tick.period;
    account(credit, over);
    return over;
  });
  if (nav.segment() != segment_) {
    if (segment_ >= 0) travel_ += (kinematics_.com() - com_start_).head<2>().norm();
    segment_ = nav.segment();
    if (begins) {
      ++committed_;
      if (nav.motion()->limit) ++shrunk_[std::string(to_string(nav.motion()->limit->reason))];
      if (planned_by_ >= 0) {
        const auto by = static_cast<std::size_t>(planned_by_);
        open_.push_back({by, guided_pose(commands_[by].command.guide), record.t + nav.motion()->duration()});
      }
      com_start_ = kinematics_.com();
      for (const Margin& margin : nav.motion()->certificate.margins) {
        if (margin.quantity == Reason::zmp) planned_margin_ = std::min(planned_margin_, margin.value);
      }
    }
  }
  if (nav.refusal()) {
    const Refusal& refusal = *nav.refusal();
    const std::string key = fmt::format("{} {}", to_string(refusal.reason), to_string(refusal.part));
    if (key != last_refused_) ++refused_[std::string(to_string(refusal.reason))];
    last_refused_ = key;
  }

  has_truth_ = record.truth != nullptr;
  if (!has_truth_) return;
  const Truth& truth = *record.truth;
  fallen_ = fallen_ || truth.fallen;
  tilt_ = std::max(tilt_, tilt_of(kinematics_.trunk().R));
  if (truth.touch.left || truth.touch.right) {
    const BySide<Pose> sole{kinematics_.sole(Side::left), kinematics_.sole(Side::right)};
    const double height = support_plane(sole, truth.touch);
    const double margin =
        support_polygon(*robot_, sole, truth.touch, kinematics_.com(), height).margin(measured_zmp(truth, height));
    measured_margin_ = std::min(measured_margin_, margin);
  }
  track(record);
  note_height(nav);
}

void Report::note_height(const Navigator& navigator) {
  const bool rested = std::exchange(rests_, navigator.phase() == Phase::hold);
  const BySide<bool>& contact = navigator.sample().contact;
  if (!contact.left || !contact.right) return;
  if (rests_) {
    const double ground = 0.5 * (kinematics_.sole(Side::left).p.z() + kinematics_.sole(Side::right).p.z());
    height_ = kinematics_.com().z() - ground;
  } else if (rested && first_height_ == 0.0) {
    first_height_ = height_;
  }
}

void Report::track(const TickRecord& record) {
  const Navigator& nav = record.navigator;
  if (nav.phase() == Phase::fallen || record.truth->fallen) return;
  const MotionSample& plan = nav.sample();
  const BySide<Pose> soles{kinematics_.sole(Side::left), kinematics_.sole(Side::right)};
  const Pose frame = anchor_correction(plan.sole, soles, plan.contact);
  planned_.set(plan.q);
  tracking_.com += (kinematics_.com() - frame * plan.com).squaredNorm();
  const Vec2 zmp = (frame * Vec3(plan.zmp.x(), plan.zmp.y(), plan.zmp_height)).head<2>();
  const Vec2 measured = measured_zmp(*record.truth, support_plane(soles, plan.contact));
  if (measured.allFinite()) tracking_.zmp += (measured - zmp).squaredNorm();
  for (const Side side : kSides) {
    tracking_.sole += 0.5 * (soles[side].p - frame * plan.sole[side].p).squaredNorm();
    tracking_.hand += 0.5 * (kinematics_.hand(side).p - frame * planned_.hand(side).p).squaredNorm();
  }
  ++tracking_.ticks;

  const Vec3 trunk = record.truth->q.head<3>();
  if (!std::exchange(tracks_, true)) way_from_ = trunk;
  // The way is counted in pieces, so that swaying does not count.
  const double piece = 0.1 * robot_->profile().stance.com_height;
  if ((trunk - way_from_).head<2>().norm() > piece) {
    way_ += (trunk - way_from_).head<2>().norm();
    way_from_ = trunk;
  }
  const double error = (nav.anchor() * Vec3(nav.state().q.head<3>()) - trunk).norm();
  tracking_.estimate = std::max(tracking_.estimate, error);
  if (way_ > 2.0 * robot_->profile().stance.com_height) tracking_.share = std::max(tracking_.share, error / way_);
}

void Report::on_plan(const PlanRecord& record) {
  if (std::holds_alternative<std::monostate>(record.result.outcome)) return;
  plan_.add(record.plan_us);
  planned_by_ = record.request.command.recall == Recall::none ? command_ : -1;
}

nlohmann::json Report::json(const std::string& world, const std::string& on, long seed, double wall) {
  if (segment_ >= 0) travel_ += (kinematics_.com() - com_start_).head<2>().norm();
  segment_ = -1;
  nlohmann::json final = {{"com", vector_json(kinematics_.com())}};
  for (const Part part : kParts) {
    const Pose pose = part == Part::trunk ? kinematics_.trunk() : guided_pose(part);
    final[std::string(to_string(part))] = {{"p", vector_json(pose.p)}, {"rpy", vector_json(rpy_of(pose.R))}};
  }
  const auto rms = [this](double sum) {
    return tracking_.ticks > 0 ? std::sqrt(sum / static_cast<double>(tracking_.ticks)) : 0.0;
  };
  const auto moved = std::count_if(commands_.begin(), commands_.end(), [](const Interval& c) { return c.moved(); });
  nlohmann::json report = {
      {"robot", robot_->profile().name},
      {"world", world},
      {"on", on},
      {"seed", seed},
      {"duration_s", duration_},
      {"falls", fallen_ ? 1 : 0},
      {"segments",
       {{"committed", committed_},
        {"caught", caught_},
        {"slips", slips_},
        {"shrunk", nlohmann::json(shrunk_)},
        {"refused", nlohmann::json(refused_)}}},
      {"commands", {{"given", commands_.size()}, {"moved", moved}}},
      {"travel_m", travel_},
      {"plan_us", plan_.summary()},
      {"tick_us", tick_.summary()},
      {"zmp_margin_m",
       {{"planned_min", finite_or_null(planned_margin_)}, {"measured_min", finite_or_null(measured_margin_)}}},
      {"tracking",
       {{"com_rms_m", rms(tracking_.com)},
        {"sole_rms_m", rms(tracking_.sole)},
        {"hand_rms_m", rms(tracking_.hand)},
        {"zmp_rms_m", rms(tracking_.zmp)},
        {"way_m", way_},
        {"estimate_max_m", tracking_.estimate},
        {"estimate_share", tracking_.share}}},
      {"com_height_m", {{"first", first_height_}, {"last", height_}}},
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
