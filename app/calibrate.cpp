#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "baton/calibrate/estimate.hpp"
#include "baton/calibrate/posing.hpp"
#include "baton/model/error.hpp"
#include "baton/robot/sensors.hpp"

namespace baton::app {
namespace {

using Json = nlohmann::json;

constexpr double kDegree = M_PI / 180.0;
constexpr double kMostMisfit = 2.0;  ///< beyond it the readings contradict what the estimate assumes

/// The constant errors that the simulator has drawn: only to judge the result.
Calibration true_errors(const Plant& plant, const RobotModel& robot, double period) {
  SensorErrors constant;
  constant.encoder_offset = plant.sensors.encoder_offset;
  constant.imu_mount = plant.sensors.imu_mount;
  constant.force_gain = plant.sensors.force_gain;
  constant.force_zero = plant.sensors.force_zero;
  const int joints = robot.nv() - 6;
  Sensors sensors(constant, joints, period, robot.mass() * kGravity, plant.seed);
  Measurement shown;
  shown.q = shown.dq = VecX::Zero(joints);
  shown.imu.acceleration = Vec3::UnitZ();
  for (const Side side : kSides)
    shown.sole[side].moment = Vec3::UnitX();
  sensors.disturb(shown);
  Calibration errors = Calibration::none(joints);
  errors.encoder_zero = shown.q;
  errors.imu_mount = rotation_log(shown.imu.attitude).head<2>();
  for (const Side side : kSides) {
    errors.force_gain[side] = shown.sole[side].moment.x();
    errors.force_zero[side] = shown.sole[side].force;
  }
  return errors;
}

double rms(const VecX& v) {
  return std::sqrt(v.squaredNorm() / static_cast<double>(v.size()));
}

/// One kind of error: its rms as it is, and as it remains when the calibration is subtracted.
struct Remaining {
  std::string what;
  std::string key;  ///< in the report
  double before = 0.0;
  double after = 0.0;
};

std::vector<Remaining> judged(const RobotModel& robot, const Calibration& truth, const Calibration& found) {
  const std::vector<int> legs = leg_joints(robot);
  const auto list = [&](const Calibration& c) {
    std::vector<VecX> kinds(4);
    kinds[0] = c.encoder_zero(legs) / kDegree;
    kinds[1] = c.imu_mount / kDegree;
    kinds[2] = VecX{{c.force_gain.left - 1.0, c.force_gain.right - 1.0}};
    kinds[3] = VecX(6);
    kinds[3] << c.force_zero.left, c.force_zero.right;
    return kinds;
  };
  const std::vector<VecX> before = list(truth);
  const std::vector<VecX> estimate = list(found);
  std::vector<Remaining> all{{"encoder zeros of the legs [deg]", "leg_zero_deg"},
                             {"IMU mount, each axis [deg]", "imu_mount_deg"},
                             {"force gains", "force_gain"},
                             {"force zeros, each axis [N]", "force_zero_n"}};
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].before = rms(before[i]);
    all[i].after = rms(before[i] - estimate[i]);
  }
  return all;
}

void print_row(const std::string& what, double value, double sigma, double prior, const char* unit) {
  fmt::print("  {:26} {:9.4f} ± {:.4f} {}{}\n", what, value, sigma, unit,
             poorly_observable(sigma, prior) ? "  poorly observable" : "");
}

void print_estimate(const RobotModel& robot, const Estimate& e) {
  fmt::print("encoder zeros\n");
  for (const int j : leg_joints(robot)) {
    print_row(robot.joints()[static_cast<std::size_t>(j)].name, e.calibration.encoder_zero[j] / kDegree,
              e.sigma.encoder_zero[j] / kDegree, e.prior.encoder_zero[j] / kDegree, "deg");
  }
  fmt::print("  joints of no leg: not observable while standing, 0\nIMU mount\n");
  for (const int i : {0, 1}) {
    print_row(i == 0 ? "roll" : "pitch", e.calibration.imu_mount[i] / kDegree, e.sigma.imu_mount[i] / kDegree,
              e.prior.imu_mount[i] / kDegree, "deg");
  }
  fmt::print("force sensors\n");
  for (const Side side : kSides) {
    const std::string foot(to_string(side));
    print_row(foot + " gain", e.calibration.force_gain[side], e.sigma.force_gain[side], e.prior.force_gain[side], "");
    for (const int i : {0, 1, 2}) {
      print_row(foot + " zero " + "xyz"[i], e.calibration.force_zero[side][i], e.sigma.force_zero[side][i],
                e.prior.force_zero[side][i], "N");
    }
  }
  fmt::print("beside them\n");
  print_row("play of the joints", e.play / kDegree, e.play_sigma / kDegree, 1.0, "deg to each side");
  print_row("yield of the hips", e.yield, e.yield_sigma, 1.0, "rad per weight x COM height");
  fmt::print("  {:26} {:9.4f} of what is assumed, at most {}\n", "misfit", e.misfit, kMostMisfit);
}

}  // namespace

int calibrate(const CalibrateOptions& o) {
  const RobotModel robot = robot_in(o.physics, o.robot);
  const World world = World::load(o.world);
  const SimulatedRobot::Parameters physics = parameters_of(o.physics, robot, "sim", o.seed);
  if (!robot.imu_in_root())
    throw InputError(fmt::format("--robot {}: has no IMU on its root; name one in the profile: parts.imu", o.robot));
  check_distinct({{"--out", o.out}, {"--report", o.report}}, files_read(o.robot, robot, world));
  OutputFile out(o.out, "--out");
  std::optional<OutputFile> report;
  if (o.report) report.emplace(*o.report, "--report");

  Simulation simulation(
      robot, world, Simulation::On::sim,
      {.physics = physics, .session = {.modes = {.gait = Gait::stop}, .source = state_named(o.physics.state)}});
  Session& session = simulation.session();
  Posing posing(robot);
  session.add(posing);
  const bool terminal = isatty(STDERR_FILENO) == 1;
  for (int shown = 0; !posing.done() && !session.fallen() && !interrupted;) {
    session.step(posing);
    if (posing.tried() == shown || !terminal) continue;
    shown = posing.tried();
    fmt::print(stderr, "\r\x1b[K{} of {} motions, {} rests, {:.0f} s", shown, Posing::moves(), posing.rests().size(),
               session.t());
  }
  if (terminal) fmt::print(stderr, "\r\x1b[K");
  if (session.fallen()) {
    fmt::print("fallen after {:.1f} s: {}; no calibration\n", session.t(), simulation.truth().fall);
    return kFallen;
  }
  if (interrupted) {
    fmt::print("interrupted after {:.1f} s; no calibration\n", session.t());
    return kFailed;
  }

  const Estimate found = estimate(robot, posing.rests());
  if (found.misfit > kMostMisfit) {
    fmt::print(
        "the readings contradict each other, {:.1f} times as much as expected: is the ground level, do soles slide, is "
        "there more play than actuators.backlash of the profile says? no calibration\n",
        found.misfit);
    return kFailed;
  }
  out.write(text_of(found.calibration, found.sigma, found.prior, robot));
  fmt::print("{:.1f} s, {} rests; ± is the standard deviation; of what is poorly observable only a part is found\n",
             session.t(), posing.rests().size());
  print_estimate(robot, found);
  fmt::print("for evaluation only, by the simulator's truth: rms of the errors, without and with the calibration\n");
  Json json = {{"robot", robot.profile().name},
               {"seed", o.seed},
               {"duration_s", session.t()},
               {"rests", posing.rests().size()},
               {"play_deg", found.play / kDegree},
               {"yield_rad", found.yield},
               {"misfit", found.misfit}};
  for (const Remaining& r :
       judged(robot, true_errors(physics.plant, robot, robot.profile().tick.period), found.calibration)) {
    fmt::print("  {:34} {:8.4f} -> {:.4f}\n", r.what, r.before, r.after);
    json["truth"][r.key] = {{"before", r.before}, {"after", r.after}};
  }
  if (report) report->write(json.dump(2) + '\n');
  return kDone;
}

}  // namespace baton::app
