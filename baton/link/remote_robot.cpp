#include "baton/link/remote_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "baton/link/answer.hpp"
#include "baton/model/error.hpp"

namespace baton::link {
namespace {

constexpr Socket::Time kSending{2000};
constexpr Socket::Time kFarewell{200};
constexpr Socket::Time kNextLook{1};   ///< from one look at a stick to the next
constexpr Socket::Time kPassing{10};   ///< from one call to the next while the robot is waited for
constexpr double kForgets = 2.0;       ///< time constant of the quickest measurement's delay: clocks may differ [s]
constexpr double kBehind = 0.02;       ///< delay from which measurements do not tell whether the robot follows [s]
constexpr double kNotFollowing = 0.1;  ///< time of rejected targets after which it follows no longer [s]

/// In what the limits of a model are wider than those of the robot; "": in nothing.
std::string wider_limits(const RobotModel& model, const JointLimits& robots) {
  constexpr double kRounded = 1e-3;  ///< relative difference up to which limits are the same, rounded numbers
  for (std::size_t i = 0; i < model.joints().size(); ++i) {
    const Joint& joint = model.joints()[i];
    const auto at = static_cast<Eigen::Index>(i);
    const auto wider = [&](const char* what, double limit, double models, bool higher) {
      const double room = kRounded * std::max(1.0, std::abs(limit));
      if (higher ? models <= limit + room : models >= limit - room) return std::string();
      return fmt::format("has {:.6g} as {} of {}, the model {:.6g}: must not be beyond the robot's", limit, what,
                         joint.name, models);
    };
    for (const std::string& difference : {wider("lowest angle", robots.lower[at], joint.position.lo, false),
                                          wider("highest angle", robots.upper[at], joint.position.hi, true),
                                          wider("no-load speed", robots.speed[at], joint.motor.no_load, true),
                                          wider("stall torque", robots.torque[at], joint.motor.stall, true)}) {
      if (!difference.empty()) return difference;
    }
  }
  return "";
}

bool same_bits(const VecX& a, const VecX& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

}  // namespace

JointLimits limits_of(const RobotModel& robot) {
  const auto each = [&](auto value) {
    VecX all(robot.nv() - 6);
    for (Eigen::Index i = 0; i < all.size(); ++i)
      all[i] = value(robot.joints()[static_cast<std::size_t>(i)]);
    return all;
  };
  return {each([](const Joint& joint) { return joint.position.lo; }),
          each([](const Joint& joint) { return joint.position.hi; }),
          each([](const Joint& joint) { return joint.motor.no_load; }),
          each([](const Joint& joint) { return joint.motor.stall; })};
}

Start start_of(const RobotModel& robot) {
  Start start{std::string(to_string(robot.profile().drive)), VecX(robot.nv() - 6), VecX(robot.nv() - 6)};
  for (Eigen::Index i = 0; i < start.kp.size(); ++i) {
    const Profile::Gains& gains = robot.joints()[static_cast<std::size_t>(i)].gains;
    start.kp[i] = gains.kp;
    start.kd[i] = gains.kd;
  }
  return start;
}

void check_robot(const RobotModel& model, const std::string& world, const Welcome& welcome, const Address& from) {
  if (welcome.version != kVersion)
    throw LinkError(
        fmt::format("the robot speaks version {} of the protocol, this program {}", welcome.version, kVersion));
  const Profile& profile = model.profile();
  const auto because = [&](const std::string& why) {
    throw InputError(fmt::format("--robot {}: the robot '{}' at {} {}", profile.name, welcome.robot, from.text(), why));
  };
  const std::vector<Joint>& own = model.joints();
  for (std::size_t i = 0; i < std::max(own.size(), welcome.joints.size()); ++i) {
    if (i >= welcome.joints.size())
      because(fmt::format("has {} joints: must be {}; '{}' is missing", i, own.size(), own[i].name));
    if (i >= own.size())
      because(fmt::format("has {} joints: must be {}, without '{}'", welcome.joints.size(), i, welcome.joints[i]));
    if (own[i].name != welcome.joints[i])
      because(fmt::format("has '{}' as joint {}: must be '{}'", welcome.joints[i], i, own[i].name));
  }
  if (std::abs(welcome.period - profile.tick.period) > 1e-9)
    because(fmt::format("has a tick of {} s: must be {} s", welcome.period, profile.tick.period));
  if (welcome.limits) {
    const std::string wider = wider_limits(model, *welcome.limits);
    if (!wider.empty()) because(wider);
  }
  if (!welcome.world.empty() && welcome.world != world)
    throw InputError(fmt::format("--world {}: the robot at {} stands in '{}': must be --world {}", world, from.text(),
                                 welcome.world, welcome.world));
}

RemoteRobot::RemoteRobot(const RobotModel& model, const std::string& world, const Parameters& parameters)
    : model_(&model),
      parameters_(parameters),
      socket_(Socket::connect(parameters.address, parameters.connecting)),
      follow_(model) {
  try {
    greet(parameters.token, world);
    await_reading(parameters.connecting);
    if (welcome_.navigates) expected_ = 0;  // its first tick begins with that measurement
    begun_ = true;
  } catch (const LinkError& error) {
    throw LinkError(fmt::format("{}: {}", parameters.address.text(), error.what()));
  }
}

RemoteRobot::~RemoteRobot() {
  try {
    socket_.send(framed(Type::bye), kFarewell);
  } catch (const LinkError&) {  // it is gone already
  }
}

Message RemoteRobot::receive(Socket::Time limit) {
  Message message = receive_from(socket_, stream_, limit);
  if (message.type == Type::refusal) complain(message);
  return message;
}

void RemoteRobot::greet(const std::string& token, const std::string& world) {
  socket_.send(framed(Type::hello, encode(Hello{kVersion, token, Role::drive})), kSending);
  const Message answer = receive(parameters_.connecting);
  if (answer.type != Type::welcome) complain_of(answer.type, "a welcome");
  welcome_ = decode_welcome(answer.body);
  check_robot(*model_, world, welcome_, parameters_.address);
  std::exchange(parameters_.accept, nullptr)(welcome_);
  Start start = start_of(*model_);
  if (welcome_.navigates) start.navigation = parameters_.navigation;
  socket_.send(framed(Type::start, encode(start)), kSending);
}

Command RemoteRobot::guide(const Command& command) {
  return guide([&command] { return command; });
}

Command RemoteRobot::guide(const std::function<Command()>& stick) {
  try {
    const auto until = std::chrono::steady_clock::now() + parameters_.answering;
    Command told = stick();
    tell(told);
    while (!take_reading(welcome_.lock_step ? parameters_.answering : kNextLook)) {
      if (std::chrono::steady_clock::now() >= until) silent_for(parameters_.answering);
      if (const Command newest = stick(); !(newest == told)) tell(told = newest);
    }
    if (damped()) throw LinkError(fmt::format("the robot was damped: {}", damped_because_));
  } catch (const LinkError& error) {
    throw LinkError(fmt::format("{}: {}", parameters_.address.text(), error.what()));
  }
  return tick_.command;
}

void RemoteRobot::drive_arms(const ArmTargets& targets) {
  arms_sent_.push_back(encode(targets));
  try {
    send(Type::arms, arms_sent_.back());
  } catch (const LinkError& error) {
    throw LinkError(fmt::format("{}: {}", parameters_.address.text(), error.what()));
  }
}

void RemoteRobot::write(const JointTarget& target) {
  if (welcome_.navigates) {
    if (!same_bits(commanded(target), tick_.target))
      throw LinkError(
          fmt::format("{}: at tick {} its navigator came to another target than the one here: another "
                      "version of the program, profile, world or processor",
                      parameters_.address.text(), reading_.sequence));
    truth_ = after_;
    return;
  }
  const Target sent{reading_.sequence, commanded(target), target.dq, target.tau};
  try {
    send(Type::target, encode(sent));
    await_reading(parameters_.answering);
    note_delay();
    if (in_a_row_ > 0 || late_ > kBehind) {
      follow_.begin();  // it holds an older target
    } else {
      follow_.take(sent.q, reading_.measurement.q);
    }
  } catch (const LinkError& error) {
    throw LinkError(fmt::format("{}: {}", parameters_.address.text(), error.what()));
  }
}

void RemoteRobot::await_reading(Socket::Time limit) {
  if (!take_reading(limit)) silent_for(limit);
}

bool RemoteRobot::take_reading(Socket::Time limit) {
  const auto until = std::chrono::steady_clock::now() + limit;
  while (true) {
    while (const std::optional<Message> message = stream_.next()) {
      if (take(*message)) return true;
    }
    const auto left = std::chrono::ceil<Socket::Time>(until - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    if (!socket_.receive(stream_.bytes(), std::min(left, kPassing)) && meanwhile_) meanwhile_();
  }
}

void RemoteRobot::tell(const Command& command) {
  send(Type::command, encode(StickPosition{expected_, command}));
}

void RemoteRobot::send(Type type, const std::string& body) {
  try {
    socket_.send(framed(type, body), kSending);
  } catch (const LinkError&) {
    hear_last_words();
    throw;
  }
}

void RemoteRobot::hear_last_words() {
  try {
    while (socket_.receive(stream_.bytes(), Socket::Time(0))) {
    }
  } catch (const LinkError&) {  // that was all
  }
  while (const std::optional<Message> message = stream_.next())
    static_cast<void>(take(*message));
}

void RemoteRobot::catch_up() {
  try {
    while (socket_.receive(stream_.bytes(), Socket::Time(0))) {
    }
    while (const std::optional<Message> message = stream_.next())
      static_cast<void>(take(*message));
  } catch (const LinkError& error) {
    throw LinkError(fmt::format("{}: {}", parameters_.address.text(), error.what()));
  }
}

void RemoteRobot::damp(const std::string& because) {
  socket_.send(framed(Type::damp, encode_text(because)), Socket::Time(0));
}

bool RemoteRobot::take(const Message& message) {
  const Eigen::Index joints = model_->nv() - 6;
  switch (message.type) {
    case Type::refusal:
      complain(message);
    case Type::truth:
      after_ = decode_truth(message.body, joints);
      if (!welcome_.navigates || !truth_) truth_ = after_;
      return false;
    case Type::rejected:
      take_rejected(message);
      return false;
    case Type::damp:
      damped_because_ = decode_text(message.body);
      return false;
    case Type::fault:
      fault_ = decode_text(message.body);
      return false;
    case Type::arms:
      take_arms(message);
      return false;
    case Type::bye:
      throw LinkError("the robot has ended the connection");
    case Type::measurement:
      reading_ = decode_reading(message.body, joints);
      if (begun_ && welcome_.navigates && !reading_.damped) complain_of(message.type, "a tick");
      if (!begun_ || !welcome_.navigates) check_sequence(reading_);
      break;
    case Type::tick:
      take_tick(message);
      break;
    default:
      complain_of(message.type, "a measurement");
  }
  if (!std::exchange(rejected_now_, false)) in_a_row_ = 0;
  return true;
}

void RemoteRobot::take_rejected(const Message& message) {
  ++rejected_;
  rejection_ = decode_text(message.body);
  if (welcome_.navigates) {  // these were for the arms; it follows its own targets all the same
    if (!arms_sent_.empty()) arms_sent_.pop_front();
    return;
  }
  if (in_a_row_++ == 0) rejecting_since_ = std::chrono::steady_clock::now();
  rejected_now_ = true;
}

void RemoteRobot::take_arms(const Message& message) {
  ArmTargets targets = decode_arms(message.body);
  if (arms_sent_.empty() || encode(targets) != arms_sent_.front())
    throw LinkError("targets for the arms that were not sent from here");
  arms_sent_.pop_front();
  arms_.push_back(std::move(targets));
}

void RemoteRobot::take_tick(const Message& message) {
  if (!begun_ || !welcome_.navigates) complain_of(message.type, "a measurement");
  const bool was_stale = tick_.stale;
  tick_ = decode_tick(message.body, model_->nv() - 6);
  reading_ = tick_.reading;
  if (tick_.stale && fault_.empty()) ++stale_;
  if (tick_.stale && !was_stale) arms_.push_back(released_arms(*model_));
  check_sequence(reading_);
}

void RemoteRobot::check_sequence(const Reading& reading) {
  if (expected_ > 0 && reading.measurement.root.has_value() != perfect_)
    throw LinkError("a measurement with a root, and one without");
  perfect_ = reading.measurement.root.has_value();
  if (reading.sequence != expected_)
    throw LinkError(fmt::format("measurement {} in place of {}", reading.sequence, expected_));
  ++expected_;
}

void RemoteRobot::note_delay() {
  if (welcome_.lock_step) return;
  const double now = std::chrono::duration<double>(parameters_.now().time_since_epoch()).count();
  const double delay = now - reading_.measurement.t;
  // A robot that has left time out is not late for ever.
  quickest_ = quickest_ < delay ? quickest_ + welcome_.period / kForgets * (delay - quickest_) : delay;
  late_ = delay - quickest_;
}

double RemoteRobot::not_followed_for() const {
  if (in_a_row_ == 0) return 0.0;
  if (welcome_.lock_step) return static_cast<double>(in_a_row_) * welcome_.period;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - rejecting_since_).count();
}

std::string RemoteRobot::follows_no_longer() const {
  const std::string address = parameters_.address.text();
  if (damped()) return fmt::format("{}: the robot was damped: {}", address, damped_because_);
  if (not_followed_for() > kNotFollowing)
    return fmt::format("{}: the robot follows no longer: {}", address, rejection_);
  if (!follow_.why().empty()) return fmt::format("{}: the robot does not follow: {}", address, follow_.why());
  return "";
}

void damp(const Address& address, const std::string& token) {
  try {
    Socket socket = Socket::connect(address, Socket::Time(3000));
    socket.send(framed(Type::hello, encode(Hello{kVersion, token, Role::damp})), kSending);
    Stream stream;
    const Message answer = receive_from(socket, stream, Socket::Time(3000));
    if (answer.type == Type::refusal) complain(answer);
    if (answer.type != Type::damp) complain_of(answer.type, "a confirmation");
  } catch (const LinkError& error) {
    const std::string why = error.what();
    throw LinkError(why.starts_with(address.text()) ? why : fmt::format("{}: {}", address.text(), why));
  }
}

}  // namespace baton::link
