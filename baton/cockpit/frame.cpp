#include "baton/cockpit/frame.hpp"

namespace baton {

Activity activity(const Navigator& navigator, bool fallen) {
  if (fallen) return Activity::fallen;
  const Purpose purpose = navigator.purpose();
  if (purpose == Purpose::none) return Activity::rest;
  if (purpose == Purpose::stop || navigator.command().recall == Recall::stop) return Activity::stopping;
  return purpose == Purpose::retrace || purpose == Purpose::home ? Activity::retracing : Activity::moving;
}

std::vector<Pose> body_poses(const mjModel& scene, const mjData& data) {
  std::vector<Pose> poses(static_cast<std::size_t>(scene.nbody));
  for (std::size_t b = 0; b < poses.size(); ++b) {
    poses[b].p = Eigen::Map<const Vec3>(data.xpos + 3 * b);
    poses[b].R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.xmat + 9 * b);
  }
  return poses;
}

}  // namespace baton
