#include "baton/link/message.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "baton/input/arm_targets_json.hpp"
#include "baton/input/json_reader.hpp"
#include "baton/model/error.hpp"

namespace baton::link {
namespace {

using Json = nlohmann::json;

static_assert(std::endian::native == std::endian::little, "numbers are sent in the machine's own order");

constexpr std::size_t kHead = 5;  ///< bytes of length and type
constexpr std::size_t kLongestText = 4096;
constexpr std::size_t kEllipsis = 3;  ///< bytes that a text which was shortened ends with
constexpr long kMostJoints = 1000;
constexpr std::uint32_t kDamped = 1;  ///< bit of the state

/// Appends numbers to a body.
class Writer {
 public:
  template <typename Number>
  Writer& number(Number value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  /// Column by column.
  template <typename Derived>
  Writer& numbers(const Eigen::MatrixBase<Derived>& values) {
    for (Eigen::Index column = 0; column < values.cols(); ++column) {
      for (Eigen::Index row = 0; row < values.rows(); ++row)
        number<double>(values(row, column));
    }
    return *this;
  }
  Writer& rotation(const Mat3& R) { return numbers(R.transpose()); }  // row by row
  Writer& wrench(const Wrench& wrench) { return numbers(wrench.force).numbers(wrench.moment); }

  std::string bytes_;
};

/// Takes them out again.
class Reader {
 public:
  /// @param sizes that the body may have [bytes]; empty: any
  /// @throws Malformed it has another
  Reader(const char* what, const std::string& body, std::initializer_list<std::size_t> sizes = {})
      : what_(what), body_(&body) {
    if (sizes.size() > 0 && std::find(sizes.begin(), sizes.end(), body.size()) == sizes.end())
      throw Malformed(fmt::format("a {} of {} bytes: must be {}", what, body.size(), fmt::join(sizes, " or ")));
  }

  template <typename Number>
  Number number() {
    Number value{};
    if (left() < sizeof value) throw Malformed(fmt::format("a {} of {} bytes is too short", what_, body_->size()));
    std::memcpy(&value, body_->data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  Vec3 vector() {
    Vec3 v;
    for (double& value : v)
      value = number<double>();
    return v;
  }
  VecX vector(Eigen::Index size) {
    VecX v(size);
    for (double& value : v)
      value = number<double>();
    return v;
  }
  Mat3 rotation() {
    Mat3 R;
    for (int row = 0; row < 3; ++row)
      R.row(row) = vector();
    return R;
  }
  Wrench wrench() {
    const Vec3 force = vector();
    return {force, vector()};
  }
  /// A byte that counts something.
  std::uint8_t below(std::uint8_t end, const char* what) {
    const auto value = number<std::uint8_t>();
    if (value >= end) throw Malformed(fmt::format("{} {} in a {}: must be below {}", what, value, what_, end));
    return value;
  }
  [[nodiscard]] std::size_t left() const { return body_->size() - at_; }
  std::string rest() { return body_->substr(std::exchange(at_, body_->size())); }

 private:
  const char* what_;
  const std::string* body_;
  std::size_t at_ = 0;
};

/// As a line that does nothing to a terminal.
std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

/// Bytes that are no UTF-8 are replaced.
std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::vector<double> listed(const VecX& v) {
  return {v.begin(), v.end()};
}

/// Reads JSON; what is wrong with it is the other end's fault.
template <typename Read>
auto from_json(const char* what, const std::string& body, const Read& read) {
  try {
    const Json json = parse_json(body, what);
    return read(JsonReader(json, what));
  } catch (const InputError& error) {
    throw Malformed(printable(error.what()));
  }
}

std::string text_in(const JsonReader& reader) {
  std::string text = printable(reader.text());
  if (text.size() > kLongestText) reader.fail(fmt::format("at most {} characters", kLongestText));
  return text;
}

constexpr std::array<std::string_view, 3> kRoles{"drive", "damp", "observe"};  // as in `Role`

std::string_view text_of(Role role) {
  return kRoles[static_cast<std::size_t>(role)];
}

Role role_in(const JsonReader& reader) {
  const std::string role = reader.one_of({kRoles[0], kRoles[1], kRoles[2]});
  return static_cast<Role>(std::find(kRoles.begin(), kRoles.end(), role) - kRoles.begin());
}

int version_in(const JsonReader& reader) {
  return static_cast<int>(reader.at("baton").integer(0, std::numeric_limits<int>::max()));
}

NavigationOptions navigation_in(const JsonReader& reader) {
  const auto is = [&](const char* key, std::initializer_list<std::string_view> known, std::string_view value) {
    return reader.has(key) && reader.at(key).one_of(known) == value;
  };
  NavigationOptions navigation;
  navigation.hangs = reader.has("hangs") && reader.at("hangs").boolean();
  if (is("duration", {"paper", "search"}, "search")) navigation.modes.duration = DurationRule::search;
  if (is("gait", {"flow", "stop"}, "stop")) navigation.modes.gait = Gait::stop;
  if (is("on_limit", {"shrink", "discard"}, "discard")) navigation.modes.on_limit = OnLimit::discard;
  for (const StateSource source : {StateSource::torques, StateSource::perfect}) {
    if (is("state", {"sensors", "torques", "perfect"}, to_string(source))) navigation.source = source;
  }
  return navigation;
}

void write_command(Writer& writer, const Command& command) {
  writer.number(static_cast<std::uint8_t>(command.guide)).number(static_cast<std::uint8_t>(command.recall));
  writer.number(command.lift.left).number(command.lift.right).numbers(command.axes);
}

Command read_command(Reader& reader) {
  Command command;
  command.guide = static_cast<Part>(reader.below(kParts.size(), "a guided part"));
  command.recall = static_cast<Recall>(reader.below(kRecalls.size(), "a recall"));
  for (const Side side : kSides)
    command.lift[side] = reader.number<double>();
  command.axes = reader.vector(command.axes.size());
  return command;
}

void check_size(Eigen::Index size, Eigen::Index wanted) {
  if (size != wanted) throw std::logic_error("the vectors of a message must have the same length");
}

}  // namespace

VecX commanded(const JointTarget& target) {
  return target.q_correction.size() > 0 ? VecX(target.q + target.q_correction) : target.q;
}

std::string framed(Type type, std::string_view body) {
  Writer writer;
  writer.number(static_cast<std::uint32_t>(body.size())).number(static_cast<std::uint8_t>(type));
  return writer.bytes_.append(body);
}

std::optional<Message> Stream::next() {
  if (bytes_.size() < kHead) return std::nullopt;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes_.data(), sizeof length);
  const auto type = static_cast<std::uint8_t>(bytes_[sizeof length]);
  if (length > kLongest)
    throw Malformed(fmt::format("a message of {} bytes: must be at most {}; is this a baton link?", length, kLongest));
  if (type < static_cast<std::uint8_t>(Type::hello) || type > static_cast<std::uint8_t>(Type::fault))
    throw Malformed(fmt::format("a message of unknown type {}; is this a baton link?", type));
  if (bytes_.size() < kHead + length) return std::nullopt;
  Message message{static_cast<Type>(type), bytes_.substr(kHead, length)};
  bytes_.erase(0, kHead + length);
  return message;
}

std::string encode(const Hello& hello) {
  return dumped({{"baton", hello.version}, {"token", hello.token}, {"role", text_of(hello.role)}});
}

std::string encode(const Welcome& welcome) {
  Json json = {{"baton", welcome.version},
               {"role", text_of(welcome.role)},
               {"robot", welcome.robot},
               {"joints", welcome.joints},
               {"period", welcome.period},
               {"lock_step", welcome.lock_step},
               {"on", welcome.on},
               {"world", welcome.world},
               {"follows", welcome.navigates ? "commands" : "targets"}};
  if (welcome.limits) {
    json["limits"] = {{"lower", listed(welcome.limits->lower)},
                      {"upper", listed(welcome.limits->upper)},
                      {"speed", listed(welcome.limits->speed)},
                      {"torque", listed(welcome.limits->torque)}};
  }
  if (!welcome.settings.empty()) json["settings"] = welcome.settings;
  return dumped(json);
}

std::string encode(const Start& start) {
  Json json = {{"drive", start.drive}, {"kp", listed(start.kp)}, {"kd", listed(start.kd)}};
  if (start.navigation) {
    const Modes& modes = start.navigation->modes;
    json["duration"] = to_string(modes.duration);
    json["gait"] = to_string(modes.gait);
    json["on_limit"] = to_string(modes.on_limit);
    json["state"] = to_string(start.navigation->source);
    json["hangs"] = start.navigation->hangs;
  }
  return dumped(json);
}

std::string encode(const Refusal& refusal) {
  return dumped({{"reason", refusal.reason}, {"text", shortened(refusal.text, kLongestText - kEllipsis)}});
}

std::string encode(const ArmTargets& targets) {
  return dumped(to_json(targets));
}

std::string encode_text(const std::string& text) {
  return dumped({{"text", shortened(text, kLongestText - kEllipsis)}});
}

namespace {

void write_reading(Writer& writer, const Reading& reading) {
  const Measurement& m = reading.measurement;
  const Eigen::Index n = m.q.size();
  check_size(m.dq.size(), n);
  const VecX torque =
      m.torque.size() > 0 ? m.torque : VecX(VecX::Constant(n, std::numeric_limits<double>::quiet_NaN()));
  check_size(torque.size(), n);
  writer.number(reading.sequence).number<std::uint32_t>(reading.damped ? kDamped : 0).number<std::uint32_t>(0);
  writer.number(m.t).number(m.age).number(reading.battery);
  writer.numbers(m.q).numbers(m.dq).numbers(torque);
  writer.rotation(m.imu.attitude).numbers(m.imu.rate).numbers(m.imu.acceleration);
  writer.wrench(m.sole.left).wrench(m.sole.right);
  if (m.root) writer.numbers(m.root->pose.p).rotation(m.root->pose.R).numbers(m.root->velocity).numbers(m.root->rate);
}

}  // namespace

std::string encode(const Reading& reading) {
  Writer writer;
  write_reading(writer, reading);
  return std::move(writer.bytes_);
}

std::string encode(const StickPosition& stick) {
  Writer writer;
  writer.number(stick.seen);
  write_command(writer, stick.command);
  return std::move(writer.bytes_);
}

std::string encode(const Tick& tick) {
  if (tick.planning.size() > Tick::kMostPlanning) throw std::logic_error("a tick has at most three planning events");
  check_size(tick.target.size(), tick.reading.measurement.q.size());
  Writer writer;
  write_command(writer, tick.command);
  writer.number<std::uint8_t>(tick.stale ? 1 : 0);
  for (std::size_t i = 0; i < Tick::kMostPlanning; ++i) {
    const auto event = i < tick.planning.size() ? static_cast<std::uint8_t>(tick.planning[i]) + 1 : 0;
    writer.number(static_cast<std::uint8_t>(event));
  }
  writer.numbers(tick.target);
  write_reading(writer, tick.reading);
  return std::move(writer.bytes_);
}

std::string encode(const Target& target) {
  check_size(target.dq.size(), target.q.size());
  check_size(target.tau.size(), target.q.size());
  Writer writer;
  writer.number(target.sequence).numbers(target.q).numbers(target.dq).numbers(target.tau);
  return std::move(writer.bytes_);
}

std::string encode(const Truth& truth) {
  Writer writer;
  writer.number(truth.t).numbers(truth.q).numbers(truth.dq).wrench(truth.sole.left).wrench(truth.sole.right);
  for (const Side side : kSides)
    writer.number<std::uint8_t>(truth.touch[side] ? 1 : 0);
  writer.number<std::uint8_t>(truth.fallen ? 1 : 0);
  return writer.bytes_.append(truth.fall);
}

Hello decode_hello(const std::string& body) {
  return from_json("hello", body, [](const JsonReader& reader) {
    Hello hello;
    hello.version = version_in(reader);
    if (hello.version != kVersion) return hello;  // all else may mean anything
    if (reader.has("token")) hello.token = text_in(reader.at("token"));
    if (reader.has("role")) hello.role = role_in(reader.at("role"));
    return hello;
  });
}

Welcome decode_welcome(const std::string& body) {
  return from_json("welcome", body, [](const JsonReader& reader) {
    Welcome welcome;
    welcome.version = version_in(reader);
    if (welcome.version != kVersion) return welcome;
    if (reader.has("role")) welcome.role = role_in(reader.at("role"));
    welcome.robot = text_in(reader.at("robot"));
    for (const JsonReader& joint : reader.at("joints").list())
      welcome.joints.push_back(text_in(joint));
    if (welcome.joints.size() > kMostJoints) reader.at("joints").fail(fmt::format("at most {} joints", kMostJoints));
    welcome.period = reader.at("period").number();
    if (!(welcome.period > 0.0)) reader.at("period").fail("above 0 s");
    welcome.lock_step = reader.at("lock_step").boolean();
    if (reader.has("on")) welcome.on = reader.at("on").one_of({"sim", "ideal", "real"});
    if (reader.has("world")) welcome.world = text_in(reader.at("world"));
    if (reader.has("follows")) welcome.navigates = reader.at("follows").one_of({"targets", "commands"}) == "commands";
    if (reader.has("settings")) {
      for (const auto& [name, value] : reader.at("settings").texts())
        welcome.settings[printable(name)] = printable(value);
    }
    if (reader.has("limits")) {
      const JsonReader limits = reader.at("limits");
      const auto joints = static_cast<Eigen::Index>(welcome.joints.size());
      welcome.limits = {limits.at("lower").vector(joints), limits.at("upper").vector(joints),
                        limits.at("speed").vector(joints), limits.at("torque").vector(joints)};
    }
    return welcome;
  });
}

Start decode_start(const std::string& body, Eigen::Index joints) {
  return from_json("start", body, [joints](const JsonReader& reader) {
    return Start{reader.at("drive").one_of({"torque", "pd", "stiff"}), reader.at("kp").vector(joints),
                 reader.at("kd").vector(joints), navigation_in(reader)};
  });
}

Refusal decode_refusal(const std::string& body) {
  return from_json("refusal", body, [](const JsonReader& reader) {
    return Refusal{text_in(reader.at("reason")), text_in(reader.at("text"))};
  });
}

ArmTargets decode_arms(const std::string& body) {
  return from_json("arms", body, [](const JsonReader& reader) { return arm_targets_in(reader); });
}

std::string decode_text(const std::string& body) {
  return from_json("text", body, [](const JsonReader& reader) { return text_in(reader.at("text")); });
}

namespace {

/// Takes the rest of the body.
Reading read_reading(Reader& reader, Eigen::Index joints) {
  Reading reading;
  reading.sequence = reader.number<std::uint64_t>();
  reading.damped = (reader.number<std::uint32_t>() & kDamped) != 0;
  static_cast<void>(reader.number<std::uint32_t>());
  Measurement& m = reading.measurement;
  m.t = reader.number<double>();
  m.age = reader.number<double>();
  reading.battery = reader.number<double>();
  m.q = reader.vector(joints);
  m.dq = reader.vector(joints);
  m.torque = reader.vector(joints);
  if (m.torque.array().isNaN().all()) m.torque.resize(0);
  m.imu.attitude = reader.rotation();
  m.imu.rate = reader.vector();
  m.imu.acceleration = reader.vector();
  for (const Side side : kSides)
    m.sole[side] = reader.wrench();
  if (reader.left() > 0) {
    m.root.emplace();
    m.root->pose.p = reader.vector();
    m.root->pose.R = reader.rotation();
    m.root->velocity = reader.vector();
    m.root->rate = reader.vector();
  }
  return reading;
}

/// Bytes of a measurement without a root, and of the root.
std::size_t reading_size(Eigen::Index joints) {
  return 256 + 24 * static_cast<std::size_t>(joints);
}
constexpr std::size_t kRootSize = 144;

}  // namespace

Reading decode_reading(const std::string& body, Eigen::Index joints) {
  const std::size_t size = reading_size(joints);
  Reader reader("measurement", body, {size, size + kRootSize});
  return read_reading(reader, joints);
}

StickPosition decode_stick(const std::string& body) {
  Reader reader("command", body, {74});
  StickPosition stick;
  stick.seen = reader.number<std::uint64_t>();
  stick.command = read_command(reader);
  return stick;
}

Tick decode_tick(const std::string& body, Eigen::Index joints) {
  const std::size_t size = 70 + 8 * static_cast<std::size_t>(joints) + reading_size(joints);
  Reader reader("tick", body, {size, size + kRootSize});
  Tick tick;
  tick.command = read_command(reader);
  tick.stale = reader.below(2, "a flag") == 1;
  for (std::size_t i = 0; i < Tick::kMostPlanning; ++i) {
    const std::uint8_t event = reader.below(3, "a planning event");
    if (event > 0) tick.planning.push_back(static_cast<PlanningEvent>(event - 1));
  }
  tick.target = reader.vector(joints);
  tick.reading = read_reading(reader, joints);
  return tick;
}

Target decode_target(const std::string& body, Eigen::Index joints) {
  Reader reader("target", body, {8 + 24 * static_cast<std::size_t>(joints)});
  Target target;
  target.sequence = reader.number<std::uint64_t>();
  target.q = reader.vector(joints);
  target.dq = reader.vector(joints);
  target.tau = reader.vector(joints);
  return target;
}

Truth decode_truth(const std::string& body, Eigen::Index joints) {
  Reader reader("truth", body);
  Truth truth;
  truth.t = reader.number<double>();
  truth.q = reader.vector(joints + 7);
  truth.dq = reader.vector(joints + 6);
  for (const Side side : kSides)
    truth.sole[side] = reader.wrench();
  for (const Side side : kSides)
    truth.touch[side] = reader.number<std::uint8_t>() != 0;
  truth.fallen = reader.number<std::uint8_t>() != 0;
  truth.fall = printable(shortened(reader.rest(), kLongestText));
  return truth;
}

}  // namespace baton::link
