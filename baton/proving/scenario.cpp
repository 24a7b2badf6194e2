#include "baton/proving/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "baton/model/error.hpp"
#include "baton/proving/stick.hpp"

namespace baton {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kHeight = 0.26;    ///< mighty's COM height, to scale lengths [m]
constexpr double kMomentum = 8.83;  ///< mighty's m √(g h), to scale impulses [N·s]
constexpr double kFirstPush = 2.0;  ///< start of single pushes [s]
constexpr int kDirections = 8;
constexpr int kInstants = 20;
constexpr double kPushInterval = 0.05;    ///< interval between instants of single pushes [s]
constexpr double kSwingPeriod = 0.8;      ///< period of the swing motion of a foot in the air [s]
constexpr double kShiftInterval = 2.0;    ///< interval between trunk shifts [s]
constexpr double kShiftHold = 0.3;        ///< time the stick is held [s]
constexpr double kShiftDeflection = 0.3;  ///< deflection

/// A stick whose position is a function of time.
class Program : public Device {
 public:
  explicit Program(std::function<Command(double t)> at) : at_(std::move(at)) {}
  [[nodiscard]] Command read(double t) override { return at_(t); }
  [[nodiscard]] DeviceStatus status() const override {
    return {.name = "program", .connected = true, .armed = true, .hint = ""};
  }

 private:
  std::function<Command(double t)> at_;
};

/// Horizontal vector of this direction and length.
Vec3 horizontal(double angle, double length) {
  return length * Vec3(std::cos(angle), std::sin(angle), 0.0);
}

/// Repeated pushes in all directions.
std::vector<Push> pushes(Dice& dice, double impulse, double seconds, int from_ms, int to_ms) {
  std::vector<Push> list;
  for (double t = kFirstPush; t < seconds; t += 1e-3 * dice.between(from_ms, to_ms))
    list.push_back({t, 0.05, horizontal(M_PI * dice.axis(), impulse)});
  return list;
}

}  // namespace

const std::vector<Scenario>& scenarios() {
  static const std::vector<Scenario> all{
      {"nominal", "the model"},
      {"friction", "friction 0.3"},
      {"mass", "mass + or - 10 %"},
      {"com", "COM of the trunk 10 mm off, horizontally"},
      {"gain", "motors give 20 % less"},
      {"strength", "motors give 10 % less at most"},
      {"delay5", "targets come 5 ms late"},
      {"delay10", "targets come 10 ms late"},
      {"noise", "encoders 0.1 deg, forces 5 %, IMU 0.5 deg off"},
      {"slope", "floor tilted by 3 deg"},
      {"tiles", "tiles up to 4 mm higher or lower"},
      {"contact", "solref 0.002 to 0.04"},
      {"kp07", "servos' kp x 0.7"},
      {"kp14", "servos' kp x 1.4"},
      {"stiff", "servos that take angles only"},
      {"stiff_tiles", "the same on tiles, 2 mm"},
      {"push", "0.6 N s every 2 to 4 s"},
      {"mix", "a milder mix of all"},
      {"push_stand", "standing: 0.6 N s, 8 directions", Driving::stand, 6.0},
      {"push_side", "standing: 1.2 N s sideways", Driving::stand, 6.0},
      {"push_fore", "standing: 1.0 N s fore and aft", Driving::stand, 6.0},
      {"push_walk", "walking: 0.6 N s, 8 directions, 20 instants", Driving::walk, 8.0},
      {"push_swing", "a foot in the air: 0.6 N s, 8 directions, 20 instants", Driving::swing, 8.0},
      {"floors", "friction 0.4 to 1.0"},
      {"glitches", "readings that are not numbers, jump, stick, are swapped or held"},
      {"glitches_walk", "the same, walking", Driving::walk},
      {"glitches_stand", "the same, standing", Driving::stand},
      {"creep", "mass + or - 10 %, the trunk shifted to and fro", Driving::shift},
  };
  return all;
}

const Scenario& scenario_named(const std::string& name) {
  for (const Scenario& scenario : scenarios()) {
    if (name == scenario.name) return scenario;
  }
  std::string names;
  for (const Scenario& scenario : scenarios())
    names += fmt::format("{}{}", names.empty() ? "" : ", ", scenario.name);
  throw InputError(fmt::format("--scenario {}: must be one of {}", name, names));
}

Plant plant_of(const Scenario& scenario, const RobotModel& robot, std::uint64_t seed, double times) {
  const double height = robot.profile().stance.com_height;
  const double length = times * height / kHeight;
  const double impulse = times * robot.mass() * std::sqrt(kGravity * height) / kMomentum;
  Dice dice(mixed_seed(seed, 77));
  const std::string_view is = scenario.name;
  const double way = M_PI * dice.axis();
  Plant plant;
  plant.seed = mixed_seed(seed, 78);
  plant.tile_side *= height / kHeight;
  const auto single_push = [&](double size, double angle) {
    const double instant = static_cast<double>(seed / kDirections % kInstants);
    plant.pushes = {{kFirstPush + kPushInterval * instant, 0.05, horizontal(angle, size * impulse)}};
  };
  if (is == "friction") plant.friction = 0.3;
  if (is == "floors") plant.friction = 0.7 + 0.3 * dice.axis();
  if (is == "mass" || is == "creep") plant.mass = 1.0 + (seed % 2 == 0 ? 0.1 : -0.1) * times;
  if (is == "com") plant.com_offset = horizontal(way, 0.010 * length);
  if (is == "gain") plant.actuators.gain = 1.0 - 0.2 * times;
  if (is == "strength") plant.actuators.strength = 1.0 - 0.1 * times;
  if (is == "delay5") plant.actuators.delay = 0.005 * times;
  if (is == "delay10") plant.actuators.delay = 0.010 * times;
  if (is == "kp07") plant.actuators.kp = 0.7;
  if (is == "kp14") plant.actuators.kp = 1.4;
  if (is == "slope") plant.tilt = horizontal(way, 3.0 * kDegree * times);
  if (is == "tiles") plant.tiles = 0.004 * length;
  if (is == "stiff_tiles") plant.tiles = 0.002 * length;
  if (is == "contact") plant.solref = 0.002 * std::pow(20.0, 0.5 * (1.0 + dice.axis()));
  if (is == "push") plant.pushes = pushes(dice, 0.6 * impulse, scenario.seconds, 2000, 4000);
  if (is == "push_stand" || is == "push_walk" || is == "push_swing")
    single_push(0.6, 2.0 * M_PI / kDirections * static_cast<double>(seed % kDirections));
  if (is == "push_side") single_push(1.2, seed % 2 == 0 ? M_PI_2 : -M_PI_2);
  if (is == "push_fore") single_push(1.0, seed % 2 == 0 ? 0.0 : M_PI);
  if (is == "noise") {
    plant.sensors.encoder_noise = 0.1 * kDegree * times;
    plant.sensors.force_noise = 0.05 * times;
    plant.sensors.imu_bias = horizontal(way, 0.5 * kDegree * times);
  }
  if (is.starts_with("glitches")) plant.sensors.glitches = 10.0 / times;
  if (is == "mix") {
    plant.friction = 0.7 + 0.3 * dice.axis();
    plant.mass = 1.0 + 0.05 * times * dice.axis();
    plant.com_offset = horizontal(way, 0.005 * length);
    plant.actuators.gain = 1.0 - 0.1 * times;
    plant.actuators.strength = 1.0 - 0.05 * times;
    plant.actuators.delay = 0.003;
    plant.sensors.encoder_noise = 0.05 * kDegree * times;
    plant.sensors.force_noise = 0.03 * times;
    plant.sensors.imu_bias = horizontal(M_PI * dice.axis(), 0.25 * kDegree * times);
    plant.tilt = horizontal(M_PI * dice.axis(), kDegree * times);
    plant.tiles = 0.001 * length;
    plant.solref = 0.005 * std::pow(2.0, dice.axis());
    plant.actuators.kp = 1.0 + 0.15 * dice.axis();
    plant.pushes = pushes(dice, 0.3 * impulse, scenario.seconds, 2000, 4000);
  }
  return plant;
}

std::unique_ptr<Device> stick_of(const Scenario& scenario, const RobotModel& robot, std::uint64_t seed) {
  switch (scenario.driving) {
    case Driving::random:
      return std::make_unique<Stick>(seed, robot.profile().tick.period);
    case Driving::stand:
      return std::make_unique<Program>([](double /*t*/) { return Command{}; });
    case Driving::walk:
      return std::make_unique<Program>([](double /*t*/) {
        Command forward;
        forward.axes[0] = 1.0;
        return forward;
      });
    case Driving::swing:
      return std::make_unique<Program>([side = seed % 2 == 0 ? Side::left : Side::right](double t) {
        Command swings;
        swings.guide = foot(side);
        swings.lift[side] = 0.5;
        if (t > 0.5 * kFirstPush) swings.axes[0] = std::fmod(t, kSwingPeriod) < 0.5 * kSwingPeriod ? 1.0 : -1.0;
        return swings;
      });
    case Driving::shift:
      return std::make_unique<Program>([](double t) {
        // To each side and back, with rests in between; one axis at a time.
        constexpr std::array<std::pair<int, double>, 4> ways{{{1, 1.0}, {1, -1.0}, {0, 1.0}, {0, -1.0}}};
        const auto [axis, way] = ways[static_cast<std::size_t>(t / kShiftInterval) % ways.size()];
        Command shift;
        const double since = std::fmod(t, kShiftInterval);
        if (since > kShiftInterval - kShiftHold) shift.axes[axis] = kShiftDeflection * way;
        return shift;
      });
  }
  return nullptr;
}

RobotModel with_drive(const RobotModel& robot, Drive drive) {
  Profile profile = robot.profile();
  if (drive == Drive::stiff && profile.drive != Drive::stiff) {
    for (auto& [name, gains] : profile.gains)
      gains.kp *= kStiff;
  }
  profile.drive = drive;
  return RobotModel(std::move(profile));
}

Drive drive_of(const Scenario& scenario, const RobotModel& robot) {
  return scenario.name.starts_with("stiff") ? Drive::stiff : robot.profile().drive;
}

}  // namespace baton
