#include "baton/record/tracking_error.hpp"

#include <algorithm>
#include <cmath>

#include "baton/record/trace.hpp"

namespace baton {
namespace {

// Fractions of the COM height.
constexpr double kPathPiece = 0.1;      ///< path length is counted in pieces this long, to exclude sway
constexpr double kLeastDistance = 2.0;  ///< distance travelled before the error ratio counts

}  // namespace

void TrackingError::add(const TickRecord& record, const Kinematics& truth) {
  const Navigator& nav = record.navigator;
  const MotionSample& plan = nav.sample();
  const BySide<Pose> soles{truth.sole(Side::left), truth.sole(Side::right)};
  const Pose frame = anchor_correction(plan.sole, soles, plan.contact);
  planned_.set(plan.q);
  squares_.com += (truth.com() - frame * plan.com).squaredNorm();
  // As far as the robot can know: an IMU that is mounted askew, for one, is no error of its balance.
  const State& state = nav.state();
  squares_.com_estimated +=
      (state.com - anchor_correction(plan.sole, state.sole, plan.contact) * plan.com).squaredNorm();
  const Vec2 planned = plan.zmp + nav.correction().com_offset;
  const Vec2 zmp = (frame * Vec3(planned.x(), planned.y(), plan.zmp_height)).head<2>();
  const Vec2 measured = measured_zmp(*record.truth, support_plane(soles, plan.contact));
  if (measured.allFinite()) {
    squares_.zmp += (measured - zmp).squaredNorm();
    forces_ = true;
  }
  for (const Side side : kSides) {
    squares_.sole += 0.5 * (soles[side].p - frame * plan.sole[side].p).squaredNorm();
    squares_.hand += 0.5 * (truth.hand(side).p - frame * planned_.hand(side).p).squaredNorm();
  }
  ++squares_.ticks;

  const double height = robot_->profile().stance.com_height;
  const Vec3 trunk = record.truth->q.head<3>();
  if (!way_from_) way_from_ = trunk;
  if ((trunk - *way_from_).head<2>().norm() > kPathPiece * height) {
    way_ += (trunk - *way_from_).head<2>().norm();
    way_from_ = trunk;
  }
  const double error = (nav.anchor() * Vec3(nav.state().q.head<3>()) - trunk).norm();
  estimate_ = std::max(estimate_, error);
  if (way_ > kLeastDistance * height) share_ = std::max(share_, error / way_);
}

nlohmann::json TrackingError::json() const {
  const auto rms = [this](double sum) {
    return squares_.ticks > 0 ? std::sqrt(sum / static_cast<double>(squares_.ticks)) : 0.0;
  };
  return {{"com_rms_m", rms(squares_.com)},
          {"com_estimated_rms_m", rms(squares_.com_estimated)},
          {"sole_rms_m", rms(squares_.sole)},
          {"hand_rms_m", rms(squares_.hand)},
          {"zmp_rms_m", forces_ || squares_.ticks == 0 ? nlohmann::json(rms(squares_.zmp)) : nlohmann::json()},
          {"way_m", way_},
          {"estimate_max_m", estimate_},
          {"estimate_share", share_}};
}

}  // namespace baton
