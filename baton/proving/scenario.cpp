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
constexpr double kMass = 5.53;      ///< mighty's mass, to scale masses, forces and impulses [kg]
constexpr double kFirstPush = 2.0;  ///< start of single pushes [s]
constexpr int kDirections = 8;
constexpr int kInstants = 20;
constexpr double kPushInterval = 0.05;    ///< interval between instants of single pushes [s]
constexpr double kPull = 5.0;             ///< time for which a hand is pulled [s]
constexpr double kPause = 3.0;            ///< time until the next pull [s]
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

}  // namespace

struct Draw {
  const RobotModel& robot;
  const Scenario& scenario;
  std::uint64_t seed;
  double times;
  Dice dice{mixed_seed(seed, 77)};
  double way = M_PI * dice.axis();  ///< a random direction [rad]

  /// Amounts for mighty, scaled: length [m], mass [kg], impulse [N·s], force [weight].
  [[nodiscard]] double length(double l) const { return times * l * height() / kHeight; }
  [[nodiscard]] double mass(double m) const { return times * m * robot.mass() / kMass; }
  [[nodiscard]] double impulse(double p) const {
    return times * p * robot.mass() * std::sqrt(kGravity * height()) / (kMass * std::sqrt(kGravity * kHeight));
  }
  [[nodiscard]] double force(double f) const { return times * f / (kMass * kGravity); }
  [[nodiscard]] double angle(double degrees) const { return times * degrees * kDegree; }
  [[nodiscard]] double ratio(double r) const { return std::pow(r, times); }
  /// From `nominal` to `drawn`, and beyond.
  [[nodiscard]] double between(double nominal, double drawn) const { return nominal * ratio(drawn / nominal); }

  [[nodiscard]] double height() const { return robot.profile().stance.com_height; }
};

namespace {

/// Repeated pushes in all directions.
void push_often(Plant& plant, Draw& draw, double impulse) {
  for (double t = kFirstPush; t < draw.scenario.seconds; t += 1e-3 * draw.dice.between(2000, 4000))
    plant.pushes.push_back({t, 0.05, horizontal(M_PI * draw.dice.axis(), draw.impulse(impulse))});
}

/// One hand is pulled steadily, in random horizontal directions, with pauses.
void pull_often(Plant& plant, Draw& draw, double force) {
  const Side hand = draw.seed % 2 == 0 ? Side::left : Side::right;
  const double impulse = kPull * draw.force(force) * draw.robot.mass() * kGravity;
  for (double t = kFirstPush; t < draw.scenario.seconds; t += kPull + kPause)
    plant.pushes.push_back({t, kPull, horizontal(M_PI * draw.dice.axis(), impulse), hand});
}

void push_once(Plant& plant, const Draw& draw, double impulse, double angle) {
  const double instant = static_cast<double>(draw.seed / kDirections % kInstants);
  plant.pushes.push_back({kFirstPush + kPushInterval * instant, 0.05, horizontal(angle, draw.impulse(impulse))});
}

void push_all_round(Plant& plant, Draw& draw) {
  push_once(plant, draw, 0.6, 2.0 * M_PI / kDirections * static_cast<double>(draw.seed % kDirections));
}

/// Contact parameters of the soles in the model: sliding friction, and contact time constant [s].
double sole_friction(const RobotModel& robot) {
  return robot.mj().geom_friction[3 * robot.sole_geoms().left.front()];
}
double sole_solref(const RobotModel& robot) {
  return robot.mj().geom_solref[2 * robot.sole_geoms().left.front()];
}

void heavier_or_lighter(Plant& plant, Draw& draw) {
  plant.mass *= draw.ratio(draw.seed % 2 == 0 ? 1.1 : 0.9);
}

void glitch(Plant& plant, Draw& draw) {
  if (draw.times > 0.0) plant.sensors.glitches = 10.0 / draw.times;
}

/// Adds errors of the sensors, each `share()` times as large.
template <typename Share>
void add(SensorErrors& to, const SensorErrors& errors, const Share& share) {
  for (double SensorErrors::*const field :
       {&SensorErrors::delay, &SensorErrors::jitter, &SensorErrors::encoder_noise, &SensorErrors::encoder_offset,
        &SensorErrors::encoder_step, &SensorErrors::imu_mount, &SensorErrors::imu_wander, &SensorErrors::yaw_drift,
        &SensorErrors::gyro_noise, &SensorErrors::accelerometer_noise, &SensorErrors::force_noise,
        &SensorErrors::force_gain, &SensorErrors::force_zero})
    to.*field += share() * errors.*field;
  to.differenced_speeds |= errors.differenced_speeds && share() > 0.0;
}

/// The same for those of the actuators.
template <typename Share>
void add(ActuatorErrors& to, const ActuatorErrors& errors, const Share& share) {
  for (double ActuatorErrors::*const field : {&ActuatorErrors::delay, &ActuatorErrors::lag, &ActuatorErrors::friction,
                                              &ActuatorErrors::backlash, &ActuatorErrors::hip_compliance})
    to.*field += share() * errors.*field;
  to.held_targets |= errors.held_targets && share() > 0.0;
  to.differenced_speeds |= errors.differenced_speeds && share() > 0.0;
}

template <typename Share>
void add_real(Plant& plant, const RobotModel& robot, const Share& share) {
  add(plant.sensors, robot.profile().sensors, share);
  add(plant.actuators, robot.profile().actuators, share);
}

/// A milder mix of the disturbances of physics and of noise.
void mix(Plant& plant, Draw& draw) {
  Dice& dice = draw.dice;
  plant.friction = draw.between(sole_friction(draw.robot), 0.7 + 0.3 * dice.axis());
  plant.mass *= draw.ratio(1.0 + 0.05 * dice.axis());
  plant.com_offset += horizontal(draw.way, draw.length(0.005));
  plant.actuators.gain *= draw.ratio(0.9);
  plant.actuators.strength *= draw.ratio(0.95);
  plant.actuators.delay += 0.003 * draw.times;
  plant.sensors.encoder_noise += draw.angle(0.05);
  plant.sensors.force_noise += 0.03 * draw.times;
  plant.sensors.imu_bias += horizontal(M_PI * dice.axis(), draw.angle(0.25));
  plant.tilt += horizontal(M_PI * dice.axis(), draw.angle(1.0));
  plant.tiles += draw.length(0.001);
  plant.solref = draw.between(sole_solref(draw.robot), 0.005 * std::pow(2.0, dice.axis()));
  plant.actuators.kp *= draw.ratio(1.0 + 0.15 * dice.axis());
  push_often(plant, draw, 0.3);
}

}  // namespace

const std::vector<Scenario>& scenarios() {
  constexpr Driving kRandom = Driving::random;
  static const std::vector<Scenario> all{
      {"nominal", "the plant alone"},
      {"friction", "friction 0.3", kRandom, 60,
       [](Plant& p, Draw& d) { p.friction = d.between(sole_friction(d.robot), 0.3); }},
      {"mass", "mass + or - 10 %", kRandom, 60, heavier_or_lighter},
      {"com", "COM of the trunk 10 mm off, horizontally", kRandom, 60,
       [](Plant& p, Draw& d) { p.com_offset += horizontal(d.way, d.length(0.010)); }},
      {"payload", "0.5 kg in one hand", kRandom, 60,
       [](Plant& p, Draw& d) { p.payload[d.seed % 2 == 0 ? Side::left : Side::right] += d.mass(0.5); }},
      {"gain", "motors give 20 % less", kRandom, 60, [](Plant& p, Draw& d) { p.actuators.gain *= d.ratio(0.8); }},
      {"strength", "motors give 10 % less at most", kRandom, 60,
       [](Plant& p, Draw& d) { p.actuators.strength *= d.ratio(0.9); }},
      {"kp07", "servos' kp x 0.7", kRandom, 60, [](Plant& p, Draw& d) { p.actuators.kp *= d.ratio(0.7); }},
      {"kp14", "servos' kp x 1.4", kRandom, 60, [](Plant& p, Draw& d) { p.actuators.kp *= d.ratio(1.4); }},
      {"delay5", "targets come 5 ms late", kRandom, 60,
       [](Plant& p, Draw& d) { p.actuators.delay += 0.005 * d.times; }},
      {"delay10", "targets come 10 ms late", kRandom, 60,
       [](Plant& p, Draw& d) { p.actuators.delay += 0.010 * d.times; }},
      {"lag", "motor torques lag by 5 ms, targets are held for a tick", kRandom, 60,
       [](Plant& p, Draw& d) {
         p.actuators.lag += 0.005 * d.times;
         p.actuators.held_targets |= d.times > 0.0;
       }},
      {"dry_friction", "joints with dry friction, 10 % of the stall torque", kRandom, 60,
       [](Plant& p, Draw& d) { p.actuators.friction += 0.10 * d.times; }},
      {"backlash", "joints with play, 0.5 deg to each side", kRandom, 60,
       [](Plant& p, Draw& d) { p.actuators.backlash += d.angle(0.5); }},
      {"hip", "hips that yield by 1 deg in single support", kRandom, 60,
       [](Plant& p, Draw& d) { p.actuators.hip_compliance += 0.1 * d.times; }},
      {"noise", "encoders 0.1 deg, forces 5 %, IMU 0.5 deg off", kRandom, 60,
       [](Plant& p, Draw& d) {
         p.sensors.encoder_noise += d.angle(0.1);
         p.sensors.force_noise += 0.05 * d.times;
         p.sensors.imu_bias += horizontal(d.way, d.angle(0.5));
       }},
      {"sensor_delay", "measurements 10 ms old", kRandom, 60,
       [](Plant& p, Draw& d) { p.sensors.delay += 0.010 * d.times; }},
      {"encoders", "encoders with zero errors of up to 1 deg", kRandom, 60,
       [](Plant& p, Draw& d) { p.sensors.encoder_offset += d.angle(1.0); }},
      {"speeds", "encoders with steps of 0.05 deg, speeds are differences, in the servos too", kRandom, 60,
       [](Plant& p, Draw& d) {
         p.sensors.encoder_step += d.angle(0.05);
         p.sensors.differenced_speeds |= d.times > 0.0;
         p.actuators.differenced_speeds |= d.times > 0.0;
       }},
      {"imu_noise", "gyro 0.02 rad/s, accelerometer 0.2 m/s2", kRandom, 60,
       [](Plant& p, Draw& d) {
         p.sensors.gyro_noise += 0.02 * d.times;
         p.sensors.accelerometer_noise += 0.2 * d.times;
       }},
      {"mount", "IMU mounted askew by 1 deg", kRandom, 60,
       [](Plant& p, Draw& d) { p.sensors.imu_mount += d.angle(1.0); }},
      {"wander", "roll and pitch wander by 1 deg rms", kRandom, 60,
       [](Plant& p, Draw& d) { p.sensors.imu_wander += d.angle(1.0); }},
      {"yaw_drift", "yaw drifts by 10 deg a minute", kRandom, 60,
       [](Plant& p, Draw& d) { p.sensors.yaw_drift += d.angle(10.0) / 60.0; }},
      {"force_zero", "force sensors up to 10 N off", kRandom, 60,
       [](Plant& p, Draw& d) { p.sensors.force_zero += d.force(10.0); }},
      {"slope", "floor tilted by 3 deg", kRandom, 60,
       [](Plant& p, Draw& d) { p.tilt += horizontal(d.way, d.angle(3.0)); }},
      {"tiles", "tiles up to 4 mm higher or lower", kRandom, 60, [](Plant& p, Draw& d) { p.tiles += d.length(0.004); }},
      {"contact", "solref 0.002 to 0.04", kRandom, 60,
       [](Plant& p, Draw& d) {
         p.solref = d.between(sole_solref(d.robot), 0.002 * std::pow(20.0, 0.5 * (1.0 + d.dice.axis())));
       }},
      {"floors", "friction 0.4 to 1.0", kRandom, 60,
       [](Plant& p, Draw& d) { p.friction = d.between(sole_friction(d.robot), 0.7 + 0.3 * d.dice.axis()); }},
      {"mat", "a mat into which the robot sinks by 3 mm", kRandom, 60,
       [](Plant& p, Draw& d) { p.mat += d.length(0.003); }},
      {"stiff", "servos that take angles only"},
      {"stiff_tiles", "the same on tiles, 2 mm", kRandom, 60, [](Plant& p, Draw& d) { p.tiles += d.length(0.002); }},
      {"push", "0.6 N s every 2 to 4 s", kRandom, 60, [](Plant& p, Draw& d) { push_often(p, d, 0.6); }},
      {"pull", "3 N at one hand for 5 s, every 8 s", kRandom, 60, [](Plant& p, Draw& d) { pull_often(p, d, 3.0); }},
      {"mix", "a milder mix of physics, noise and pushes", kRandom, 60, mix},
      {"real", "the profile's errors of sensors and actuators", kRandom, 60,
       [](Plant& p, Draw& d) { add_real(p, d.robot, [&d] { return d.times; }); }},
      {"real_stiff", "the same with servos that take angles only", kRandom, 60,
       [](Plant& p, Draw& d) { add_real(p, d.robot, [&d] { return d.times; }); }},
      {"drawn", "each of them between none and twice", kRandom, 60,
       [](Plant& p, Draw& d) { add_real(p, d.robot, [&d] { return 2.0 * d.times * d.dice.share(); }); }},
      {"push_stand", "standing: 0.6 N s, 8 directions", Driving::stand, 6.0, push_all_round},
      {"push_side", "standing: 1.2 N s sideways", Driving::stand, 6.0,
       [](Plant& p, Draw& d) { push_once(p, d, 1.2, d.seed % 2 == 0 ? M_PI_2 : -M_PI_2); }},
      {"push_fore", "standing: 1.0 N s fore and aft", Driving::stand, 6.0,
       [](Plant& p, Draw& d) { push_once(p, d, 1.0, d.seed % 2 == 0 ? 0.0 : M_PI); }},
      {"push_walk", "walking: 0.6 N s, 8 directions, 20 instants", Driving::walk, 8.0, push_all_round},
      {"push_swing", "a foot in the air: 0.6 N s, 8 directions, 20 instants", Driving::swing, 8.0, push_all_round},
      {"glitches", "readings that are not numbers, jump, stick, are swapped or held", kRandom, 60, glitch},
      {"glitches_walk", "the same, walking", Driving::walk, 60, glitch},
      {"glitches_stand", "the same, standing", Driving::stand, 60, glitch},
      {"creep", "mass + or - 10 %, the trunk shifted to and fro", Driving::shift, 60, heavier_or_lighter},
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

Plant plant_of(const Scenario& scenario, const RobotModel& robot, std::uint64_t seed, double times, const Plant& base) {
  Plant plant = base;
  plant.seed = mixed_seed(seed, 78);
  plant.tile_side = Plant{}.tile_side * robot.profile().stance.com_height / kHeight;
  Draw draw{robot, scenario, seed, times};
  if (scenario.deviate != nullptr) scenario.deviate(plant, draw);
  return plant;
}

Plant plant_of(bool real, const Scenario* scenario, const RobotModel& robot, std::uint64_t seed, double times) {
  Plant plant = real ? real_plant(robot, seed) : Plant{};
  return scenario != nullptr ? plant_of(*scenario, robot, seed, times, plant) : plant;
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
    for (auto& [name, gains] : profile.gains) {
      gains.kp *= kStiff;
      gains.kd *= std::sqrt(kStiff);  // the same damping ratio
    }
  }
  profile.drive = drive;
  return RobotModel(std::move(profile));
}

Drive drive_of(const Scenario& scenario, const RobotModel& robot) {
  return scenario.name.find("stiff") != std::string_view::npos ? Drive::stiff : robot.profile().drive;
}

}  // namespace baton
