#include "baton/link/robot_server.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "baton/link/engage.hpp"
#include "baton/model/error.hpp"

namespace baton::link {

using namespace std::chrono_literals;

namespace {

constexpr std::size_t kMostUnsent = kLongest + (1U << 16U);  ///< a peer that leaves more does not listen [bytes]
constexpr std::chrono::seconds kGreeting{5};  ///< by which a connection has to say what it wants, or be closed
constexpr std::size_t kMostGuests = 16;       ///< who have said nothing yet; the same who have been dismissed
constexpr int kMostInTurn = 16;               ///< messages of one peer before others are heard
constexpr std::chrono::seconds kRefusals{1};  ///< of refusals within this time one is logged
constexpr std::size_t kMostAtOnce = kLongest + (1U << 16U);  ///< read from one peer before others are heard [bytes]
constexpr long kEveryRejection = 200;                        ///< of so many rejections in a row one is logged
constexpr std::uint64_t kOldest =
    20;                          ///< of the newest measurement, in real time: an answer to an older one is too late
constexpr int kMostBehind = 20;  ///< ticks that are caught up with, after which the clock is set anew

/// Takes as long whatever the token is, so that its time tells nothing about it.
bool same_token(const std::string& a, const std::string& b) {
  unsigned differs = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size(); ++i)
    differs |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b.empty() ? 0 : b[i % b.size()]);
  return differs == 0;
}

}  // namespace

RobotServer::RobotServer(const RobotModel& model, Robot& robot, Parameters parameters)
    : model_(&model),
      robot_(&robot),
      parameters_(std::move(parameters)),
      listener_(Socket::listen(parameters_.listen)),
      check_(model) {
  if (parameters_.token.empty() && !parameters_.listen.loopback())
    throw InputError(
        fmt::format("{} can be reached by others: needs a token, which drivers must know", parameters_.listen.text()));
}

Address RobotServer::address() const {
  return {parameters_.listen.host, listener_.port()};
}

void RobotServer::serve(Socket::Time limit) {
  std::vector<pollfd> all{{listener_.descriptor(), POLLIN, 0}};
  for (const Peer& guest : guests_)
    all.push_back({guest.socket.descriptor(), POLLIN, 0});
  for (const std::optional<Peer>* peer : {&driver_, &observer_}) {
    if (!*peer) continue;
    const short events = (*peer)->unsent.empty() ? POLLIN : POLLIN | POLLOUT;
    all.push_back({(*peer)->socket.descriptor(), events, 0});
  }
  std::chrono::nanoseconds wait = more_ ? Socket::Time(0) : limit;
  if (parameters_.remote != nullptr) {
    wait = runs_ || parameters_.hold ? 0ns : std::min<std::chrono::nanoseconds>(wait, period());
  } else if (parameters_.real_time && (runs_ || observer_)) {
    wait = std::clamp<std::chrono::nanoseconds>(due_ - parameters_.now(), 0ns, wait);
  }
  const auto seconds = std::chrono::floor<std::chrono::seconds>(wait);
  const timespec longest{seconds.count(), (wait - seconds).count()};
  if (ppoll(all.data(), all.size(), &longest, nullptr) < 0) return;  // by a signal
  hear_all();
  advance_if_due();
}

void RobotServer::hear_all() {
  more_ = false;
  std::string why;
  if (driver_ && !listen_to(*driver_, why)) drop_driver(why);
  if (observer_ && !listen_to(*observer_, why)) drop_observer(why);
  const auto now = parameters_.now();
  std::vector<Peer> staying;
  for (Peer& guest : guests_) {
    if (!listen_to(guest, why) || now - guest.since > kGreeting) continue;
    if (guest.welcomed && guest.observes) {
      observer_ = std::move(guest);
      if (!listen_to(*observer_, why)) drop_observer(why);
    } else if (guest.welcomed) {
      driver_ = std::move(guest);
      state_ = State::driven;
      if (!listen_to(*driver_, why)) drop_driver(why);
    } else {
      staying.push_back(std::move(guest));
    }
  }
  guests_ = std::move(staying);
  see_off();
  if (driver_ && !driver_->started && now - driver_->since > kGreeting) drop_driver("it does not start");
  accept();
}

bool RobotServer::listen_to(Peer& peer, std::string& why) {
  why.clear();
  try {
    if (!peer.unsent.empty()) tell(peer, {});
    std::exception_ptr gone;  // after what it has said before
    try {
      while (peer.stream.bytes().size() < kMostAtOnce && peer.socket.receive(peer.stream.bytes(), Socket::Time(0))) {
      }
    } catch (const LinkError&) {
      gone = std::current_exception();
    }
    try {
      const bool guest = !peer.welcomed;
      int heard = 0;
      while (std::optional<Message> message = peer.stream.next()) {
        if (!hear(peer, *message)) return false;
        if (guest && peer.welcomed) break;  // goes on as what it is then
        if (++heard == kMostInTurn) {
          more_ = true;
          return true;
        }
      }
    } catch (const Malformed& error) {
      return refuse(peer, "protocol", error.what());
    }
    if (gone) std::rethrow_exception(gone);
    return true;
  } catch (const LinkError& error) {
    why = error.what();
    return false;
  }
}

void RobotServer::accept() {
  while (std::optional<Socket> socket = listener_.accept()) {
    // Who has been silent longest makes room: nobody can keep away the one who damps.
    if (guests_.size() >= kMostGuests) guests_.erase(guests_.begin());
    guests_.push_back({*std::move(socket), {}, {}, parameters_.now()});
  }
}

bool RobotServer::hear(Peer& peer, const Message& message) {
  if (!peer.welcomed) {
    if (message.type == Type::hello) return greet(peer, message);
    return refuse(peer, "protocol", "a connection begins with a hello");
  }
  if (peer.observes) {
    if (message.type == Type::bye) return false;
    return refuse(peer, "protocol",
                  fmt::format("a message of type {} from an observer: it may send nothing but bye, and moves nothing",
                              static_cast<int>(message.type)));
  }
  switch (message.type) {
    case Type::start:
      return begin(peer, message);
    case Type::target:
    case Type::command:
    case Type::arms:
      return take(peer, message);
    case Type::damp:
      // Only with a text: a bit that was turned over makes a command's type that of a damp message.
      damp("asked for by the driver: " + decode_text(message.body));
      return true;
    case Type::bye:
      parameters_.log("the driver has handed the robot back");
      return false;
    default:
      return refuse(peer, "protocol",
                    fmt::format("a message of type {} from a driver", static_cast<int>(message.type)));
  }
}

bool RobotServer::greet(Peer& peer, const Message& message) {
  const Hello hello = decode_hello(message.body);
  if (hello.version != kVersion)
    return refuse(peer, "version", fmt::format("version {} of the protocol: must be {}", hello.version, kVersion));
  if (!parameters_.token.empty() && !same_token(hello.token, parameters_.token))
    return refuse(peer, "token", hello.token.empty() ? "a token is needed" : "the token is wrong");
  if (hello.role == Role::observe) return greet_observer(peer);
  if (parameters_.only_observed)
    return refuse(peer, "busy", "somebody else controls this robot: nothing is commanded from here");
  if (hello.role == Role::damp) {
    damp("asked for over the network");
    tell(peer, framed(Type::damp, encode_text(damped_because_)));
    return false;
  }
  if (state_ == State::damped) return refuse(peer, "damped", damped_because_);
  if (driver_) return refuse(peer, "busy", "somebody drives the robot already");
  if (retired_) return refuse(peer, "busy", "the robot's end is being ended");
  welcome(peer, Role::drive);
  return true;
}

bool RobotServer::greet_observer(Peer& peer) {
  if (observer_) return refuse(peer, "busy", "somebody observes the robot already");
  peer.observes = true;
  welcome(peer, Role::observe);
  shown_ = 0;
  if (!runs_) due_ = parameters_.now() + period();
  parameters_.log("an observer looks on");
  return true;
}

void RobotServer::welcome(Peer& peer, Role role) {
  Welcome welcome;
  welcome.role = role;
  welcome.robot = model_->profile().name;
  for (const Joint& joint : model_->joints())
    welcome.joints.push_back(joint.name);
  welcome.period = model_->profile().tick.period;
  welcome.lock_step = !parameters_.real_time;
  welcome.on = parameters_.on;
  welcome.world = parameters_.world;
  welcome.navigates = parameters_.navigates_in != nullptr;
  welcome.limits = limits_of(*model_);
  welcome.settings = parameters_.settings;
  tell(peer, framed(Type::welcome, encode(welcome)));
  peer.welcomed = true;  // `serve` makes it the driver or observer
}

bool RobotServer::begin(Peer& peer, const Message& message) {
  if (peer.started) return refuse(peer, "protocol", "a second start");
  if (state_ == State::damped) return refuse(peer, "damped", damped_because_);
  const Start start = decode_start(message.body, model_->nv() - 6);
  if (const std::optional<std::string> why =
          parameters_.set_servos ? parameters_.set_servos(start) : wrong_servos(start))
    return refuse(peer, "servos", *why);
  if (parameters_.remote == nullptr) {
    if (std::exchange(onboard_, nullptr)) parameters_.ended();  // the robot does not stand where that one left it
    robot_->reset();
  } else if (!resting()) {
    return refuse(peer, "posture", "the robot is still coming to rest: try again");
  }
  if (parameters_.navigates_in != nullptr) {
    const NavigationOptions navigation = start.navigation.value_or(NavigationOptions{});
    for (const auto& check : {lacks, in_other_units}) {
      if (const auto what = check(robot_->read(), navigation.source)) return refuse(peer, "sensors", *what);
    }
    Onboard::Parameters parameters{navigation, !parameters_.real_time, nullptr};
    if (parameters_.planning) parameters.planning = parameters_.planning(navigation.modes);
    try {
      onboard_ = std::make_unique<Onboard>(*model_, *parameters_.navigates_in, *robot_, std::move(parameters));
    } catch (const InputError& error) {
      return refuse(peer, "posture", error.what());
    }
    onboard_->hold(!fault_.empty());
    onboard_->session().add(condition_.emplace(*model_));
    parameters_.began(*onboard_, navigation);
  }
  stale_ = false;
  rest_logged_ = false;
  peer.started = true;
  reading_ = {};
  reading_.measurement = robot_->read();
  const VecX zero = VecX::Zero(reading_.measurement.q.size());
  target_ = {reading_.measurement.q, zero, zero, zero, {true, true}, {}};
  check_.begin(target_.q);
  rejections_ = 0;
  next_ = 0;
  runs_ = true;
  due_ = parameters_.now() + period();
  parameters_.log("a driver has taken over");
  if (!fault_.empty()) tell_fault(peer);
  send_reading(peer);
  if (!onboard_) show();  // else the first tick does
  return true;
}

std::optional<std::string> RobotServer::wrong_servos(const Start& start) const {
  const std::string drive(to_string(model_->profile().drive));
  if (start.drive != drive) return fmt::format("drive {}: the servos are {}", start.drive, drive);
  for (std::size_t i = 0; i < model_->joints().size(); ++i) {
    const Joint& joint = model_->joints()[i];
    const auto at = static_cast<Eigen::Index>(i);
    if (start.kp[at] != joint.gains.kp || start.kd[at] != joint.gains.kd)
      return fmt::format("{}: kp {:.6g}, kd {:.6g}: the servo has {:.6g}, {:.6g}", joint.name, start.kp[at],
                         start.kd[at], joint.gains.kp, joint.gains.kd);
  }
  return std::nullopt;
}

bool RobotServer::take(Peer& peer, const Message& message) {
  if (!peer.started) return refuse(peer, "protocol", "a target or command before the start");
  if (message.type == Type::target) {
    if (onboard_) return refuse(peer, "protocol", "a target: must be a command");
    follow(peer, message);
    return true;
  }
  const bool arms = message.type == Type::arms;
  if (!onboard_)
    return refuse(peer, "protocol", fmt::format("{}: must be a target", arms ? "targets for the arms" : "a command"));
  if (!arms) return guide(peer, message);
  drive_arms(peer, message);
  return true;
}

bool RobotServer::guide(Peer& peer, const Message& message) {
  const StickPosition stick = decode_stick(message.body);
  const std::uint64_t ticks = onboard_->ticks();
  if (stick.seen > ticks || (!parameters_.real_time && stick.seen < ticks))
    return refuse(peer, "protocol",
                  fmt::format("a command after tick {}: must be {}{}", stick.seen,
                              parameters_.real_time ? "at most " : "", ticks));
  onboard_->hear(stick);
  if (parameters_.real_time) return true;
  move();
  report();
  show();
  return true;
}

void RobotServer::drive_arms(Peer& peer, const Message& message) {
  const ArmTargets targets = decode_arms(message.body);
  try {
    if (state_ == State::damped) throw InputError("the robot is damped, so nothing drives the arms");
    onboard_->drive_arms(targets);
  } catch (const InputError& error) {
    tell(peer, framed(Type::rejected, encode_text(error.what())));
    return;
  }
  tell(peer, framed(Type::arms, message.body));  // so that it knows from which tick on they count
}

void RobotServer::follow(Peer& peer, const Message& message) {
  const Target target = decode_target(message.body, model_->nv() - 6);
  if (const std::optional<std::string> why = judge(target)) {
    if (rejections_++ % kEveryRejection == 0) parameters_.log("target rejected: " + *why);
    tell(peer, framed(Type::rejected, encode_text(*why)));
  } else {
    target_.q = target.q;
    target_.dq = target.dq;
    target_.tau = target.tau;
    next_ = target.sequence + 1;
    rejections_ = 0;
    if (parameters_.immediate && state_ != State::damped) robot_->write(target_);
  }
  if (parameters_.real_time) return;
  move();
  report();
  show();
}

std::optional<std::string> RobotServer::judge(const Target& target) {
  const std::uint64_t newest = reading_.sequence;
  const std::uint64_t oldest = parameters_.real_time ? std::max(next_, newest - std::min(newest, kOldest)) : newest;
  if (target.sequence > newest || target.sequence < oldest)
    return fmt::format("an answer to measurement {}: must be {}", target.sequence,
                       oldest < newest ? fmt::format("from {} to {}", oldest, newest) : fmt::format("{}", newest));
  return check_.reject(target, reading_.measurement.q);
}

void RobotServer::move() {
  if (parameters_.remote != nullptr) reading_.battery = parameters_.remote->battery();
  if (state_ == State::damped) {
    brake();
  } else if (onboard_) {
    reading_ = onboard_->step(reading_.battery).reading;
    return log_changes();
  } else if (!answered()) {
    target_.dq.setZero();  // nothing to follow: it stays where the last good target was
  }
  if (!parameters_.immediate) robot_->write(target_);
  ++reading_.sequence;
  reading_.measurement = robot_->read();
}

void RobotServer::look() {
  reading_.measurement = robot_->read();
  show();
}

void RobotServer::show() {
  if (!observer_) return;
  Reading shown = reading_;
  shown.sequence = shown_++;
  shown.damped = state_ == State::damped;
  try {
    send(*observer_, framed(Type::measurement, encode(shown)));
  } catch (const LinkError& error) {
    drop_observer(error.what());
  }
}

void RobotServer::report() {
  if (!driver_ || !driver_->started) return;
  if (onboard_ && state_ != State::damped) {
    send(*driver_, framed(Type::tick, encode(onboard_->tick())));
  } else {
    send_reading(*driver_);
  }
}

void RobotServer::log_changes() {
  if (driver_ && fault_.empty() && std::exchange(stale_, onboard_->stale()) != onboard_->stale())
    parameters_.log(onboard_->stale() ? fmt::format("link: the stick's positions are more than {} s old: comes to rest",
                                                    Onboard::kFresh)
                                      : "link: the stick counts again");
  for (const ConditionLog::Line& line : condition_->take())
    parameters_.log(fmt::format("{:.2f} s: {}", line.t, line.text));
  const bool rests = !driver_ && resting();
  if (rests && !rest_logged_) {
    parameters_.log("at rest, without a driver");
    parameters_.ended();
  }
  rest_logged_ = rests;
}

bool RobotServer::resting() const {
  if (!onboard_ || !parameters_.real_time || state_ == State::damped) return true;
  return onboard_->session().navigator().guard() != Guard::armed || onboard_->rests();
}

void RobotServer::retire() {
  retired_ = true;
  if (!driver_) return;
  try {
    tell(*driver_, framed(Type::bye));
  } catch (const LinkError&) {  // it is gone already
  }
  drop_driver("this end is being ended");
}

void RobotServer::brake() {
  target_.q = reading_.measurement.q;
  target_.dq.setZero();
  target_.tau.setZero();
}

void RobotServer::advance_if_due() {
  if (parameters_.remote != nullptr) return advance_remote();
  if (!parameters_.real_time || !(runs_ || observer_)) return;
  for (int tick = 0; tick < kMostBehind && parameters_.now() >= due_; ++tick) {
    due_ += period();
    advance();
  }
  const Clock::time_point now = parameters_.now();
  if (now < due_) return;
  const Clock::time_point due = std::exchange(due_, now + period());
  parameters_.log("too slow for real time: time was left out");
  if (onboard_) onboard_->lose(std::chrono::duration<double>(due_ - due).count());
}

void RobotServer::advance_remote() {
  RemoteRobot& remote = *parameters_.remote;
  if (runs_) {
    advance();  // up to its next measurement
  } else if (parameters_.hold && state_ != State::damped) {
    remote.catch_up();
    robot_->write(*parameters_.hold);
    look();
  } else {
    remote.catch_up();
    if (remote.read().t != reading_.measurement.t) look();
  }
  if (remote.damped()) damp("at its own end: " + remote.damped_because());
  if (remote.fault() != remote_fault_) {
    remote_fault_ = remote.fault();
    look_at_faults();
  }
  const std::string why = remote.damped() ? "" : remote.follows_no_longer();
  if (!driver_ || why.empty()) return;
  try {
    static_cast<void>(refuse(*driver_, "robot", why));
  } catch (const LinkError&) {  // it is gone already
  }
  drop_driver(why);
}

void RobotServer::advance() {
  if (!runs_) return look();
  move();
  try {
    report();
  } catch (const LinkError& error) {
    drop_driver(error.what());
  }
  show();
}

RobotServer::Clock::duration RobotServer::period() const {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(model_->profile().tick.period));
}

void RobotServer::send_reading(Peer& peer) {
  reading_.damped = state_ == State::damped;
  send(peer, framed(Type::measurement, encode(reading_)));
}

void RobotServer::send(Peer& peer, const std::string& message) {
  std::string bytes;
  if (const Truth* truth = robot_->truth()) bytes = framed(Type::truth, encode(*truth));
  tell(peer, bytes + message);
}

void RobotServer::tell(Peer& peer, const std::string& bytes) {
  peer.unsent += bytes;
  peer.unsent.erase(0, peer.socket.send_some(peer.unsent));
  if (peer.unsent.size() > kMostUnsent) throw LinkError("the other end takes nothing");
}

bool RobotServer::refuse(Peer& peer, const std::string& reason, const std::string& text) {
  const Clock::time_point now = parameters_.now();
  ++refusals_;
  if (now - refused_at_ >= kRefusals || refused_at_ == Clock::time_point()) {
    const std::string others = refusals_ > 1 ? fmt::format(", and {} others since the last", refusals_ - 1) : "";
    parameters_.log(fmt::format("refused ({}): {}{}", reason, text, others));
    refusals_ = 0;
    refused_at_ = now;
  }
  return dismiss(peer, framed(Type::refusal, encode(Refusal{reason, text})));
}

bool RobotServer::dismiss(Peer& peer, const std::string& last) {
  tell(peer, last);
  peer.since = parameters_.now();
  if (dismissed_.size() >= kMostGuests) dismissed_.erase(dismissed_.begin());
  dismissed_.push_back(std::move(peer));
  return false;
}

void RobotServer::see_off() {
  std::erase_if(dismissed_, [now = parameters_.now()](Peer& peer) {
    try {
      peer.unsent.empty() ? peer.socket.finish() : tell(peer, {});
      for (int k = 0; k < kMostInTurn && peer.socket.receive(peer.stream.bytes(), Socket::Time(0)); ++k)
        peer.stream.bytes().clear();
    } catch (const LinkError&) {  // closed
      return true;
    }
    return now - peer.since > kGreeting;
  });
}

void RobotServer::drop_driver(const std::string& why) {
  if (!why.empty()) parameters_.log("driver lost: " + why);
  driver_.reset();
  if (onboard_) onboard_->driver_gone();
  if (onboard_ && !parameters_.real_time) parameters_.ended();
  if (state_ == State::driven) state_ = State::waiting;
}

void RobotServer::drop_observer(const std::string& why) {
  parameters_.log(why.empty() ? "the observer has left" : "observer lost: " + why);
  observer_.reset();
}

void RobotServer::damp(const std::string& because) {
  if (state_ == State::damped) return;
  state_ = State::damped;
  damped_because_ = because;
  parameters_.log("damped: " + because);
  if (driver_) {
    try {
      tell(*driver_, framed(Type::damp, encode_text(because)));
    } catch (const LinkError&) {  // `serve` finds that out, too
    }
  }
  if (parameters_.remote != nullptr && !parameters_.remote->damped()) {
    try {
      parameters_.remote->damp(because);
    } catch (const LinkError& error) {  // its next measurement does not come, which ends this end
      parameters_.log(fmt::format("the robot could not be told: {}", error.what()));
    }
  }
  parameters_.ended();
}

void RobotServer::set_fault(const std::string& fault) {
  if (fault == own_fault_) return;
  own_fault_ = fault;
  look_at_faults();
}

void RobotServer::look_at_faults() {
  const std::string& fault = own_fault_.empty() ? remote_fault_ : own_fault_;
  if (fault == fault_) return;
  fault_ = fault;
  parameters_.log(fault.empty() ? "fault over" : "fault: " + fault + ": comes to rest");
  if (onboard_) onboard_->hold(!fault.empty());
  if (!driver_ || !driver_->started) return;
  try {
    tell_fault(*driver_);
  } catch (const LinkError&) {  // `serve` finds that out, too
  }
}

void RobotServer::tell_fault(Peer& peer) {
  tell(peer, framed(Type::fault, encode_text(fault_)));
}

void RobotServer::arm() {
  if (state_ != State::damped) return;
  if (parameters_.remote != nullptr && parameters_.remote->damped())
    return parameters_.log("not armed: arm the robot at its own end, and start this one again");
  if (driver_) {
    try {
      dismiss(*driver_, framed(Type::bye));
    } catch (const LinkError&) {  // it is gone already
    }
  }
  driver_.reset();
  onboard_.reset();  // it does not stand where that one left it
  state_ = State::waiting;
  parameters_.log("armed");
}

}  // namespace baton::link
