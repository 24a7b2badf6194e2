#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <iterator>
#include <utility>

#include "baton/input/arm_targets_json.hpp"
#include "baton/record/event_json.hpp"
#include "baton/record/json.hpp"
#include "baton/record/recording.hpp"
#include "baton/record/recording_file.hpp"

namespace baton {
namespace {

constexpr double kEstimates = 0.04;  ///< from estimates to estimates [s]
constexpr double kRounding = 1e5;    ///< of estimates [1/m]
constexpr const char* kWorldFrame = "world";
constexpr const char* kRootFrame = "root";

class Fnv {
 public:
  void add(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i)
      hash_ = (hash_ ^ bytes[i]) * 0x100000001b3ULL;
  }
  [[nodiscard]] std::string text() const { return fmt::format("{:016x}", hash_); }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

/// A time as ROS has it, in 32 bits of seconds.
std::int64_t nanoseconds(double t) {
  constexpr double kMost = 2147483647.0;
  return std::isfinite(t) ? std::llround(1e9 * std::clamp(t, -kMost, kMost)) : 0;
}

mcap::Metadata texts(const nlohmann::json& head) {
  mcap::Metadata metadata;
  for (const auto& [key, value] : head.items())
    metadata[key] = value.is_string() ? value.get<std::string>() : value.dump();
  metadata["recording"] = std::to_string(kRecordingVersion);
  return metadata;
}

mcap::Writer begun(std::unique_ptr<mcap::Output> output, const nlohmann::json& head,
                   const std::vector<mcap::Attachment>& attachments) {
  mcap::Writer writer(std::move(output), "ros2", "baton " + head.value("baton", ""));
  writer.add("baton", texts(head));
  for (const mcap::Attachment& attachment : attachments)
    writer.add(attachment);
  std::map<std::string_view, std::uint16_t> schemas;
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    const auto topic = static_cast<Topic>(i);
    std::uint16_t& schema = schemas[info(topic).schema];
    if (schema == 0) schema = writer.add(schema_of(topic));
    writer.add(mcap::Channel{schema, std::string(info(topic).topic), info(topic).ros ? "cdr" : "json"});
  }
  return writer;
}

/// Rounded to 2⁻¹⁷, 8e-6: with fewer digits there is less to compress.
double rounded(double x) {
  return std::ldexp(std::round(std::ldexp(x, 17)), -17);
}

/// Numbers as a JSON array, rounded.
template <typename Vector>
void put_rounded(std::string& out, std::string_view key, const Vector& values) {
  fmt::format_to(std::back_inserter(out), ",\"{}\":[", key);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (i > 0) out += ',';
    if (std::isfinite(values[i])) {
      fmt::format_to(std::back_inserter(out), "{}", std::round(kRounding * values[i]) / kRounding + 0.0);
    } else {
      out += "null";
    }
  }
  out += ']';
}

}  // namespace

std::string checksum(const JointTarget& target) {
  Fnv hash;
  for (const VecX* v : {&target.q, &target.dq, &target.ddq, &target.tau, &target.q_correction})
    hash.add(v->data(), static_cast<std::size_t>(v->size()) * sizeof(double));
  const std::array<unsigned char, 2> contact{target.contact.left, target.contact.right};
  hash.add(contact.data(), contact.size());
  return hash.text();
}

double recorded_angle(double angle) {
  return std::ldexp(std::round(std::ldexp(angle, 20)), -20);
}

std::string checksum(std::string_view bytes) {
  Fnv hash;
  hash.add(bytes.data(), bytes.size());
  return hash.text();
}

RecordingWriter::RecordingWriter(const RobotModel& robot, const std::filesystem::path& file, const nlohmann::json& head,
                                 Parameters parameters)
    : RecordingWriter(robot, "--record " + file.string(), std::make_unique<RecordingFile>(file, "--record"), head,
                      std::move(parameters)) {}

RecordingWriter::RecordingWriter(const RobotModel& robot, std::string name, std::unique_ptr<mcap::Output> output,
                                 const nlohmann::json& head, Parameters parameters)
    : name_(std::move(name)),
      parameters_(std::move(parameters)),
      thread_(begun(std::move(output), head, parameters_.attachments), thread_parameters()),
      each_(std::max(1L, std::lround(kEstimates / robot.profile().tick.period))),
      perfect_(head.value("state", "") == to_string(StateSource::perfect)) {
  for (const Joint& joint : robot.joints())
    measured_.name.push_back(joint.name);
  target_.name = measured_.name;
  imu_.header.frame = "imu";
  root_.header.frame = kWorldFrame;
  root_.child = kRootFrame;
}

mcap::WriterThread::Parameters RecordingWriter::thread_parameters() {
  return {.sync = parameters_.live, .on_failure = [this](const std::string& why) { warn(why); }};
}

void RecordingWriter::warn(const std::string& why) {
  if (!warned_.exchange(true) && parameters_.warn) parameters_.warn(why);
}

bool RecordingWriter::begin(std::uint64_t time) {
  if (chunk_ != nullptr && !chunk_->empty() && time - begun_ >= kChunkTime) {
    thread_.hand_over();
    chunk_ = nullptr;
  }
  if (chunk_ != nullptr) return true;
  if (!parameters_.live) thread_.wait();
  chunk_ = thread_.chunk();
  begun_ = time;
  if (chunk_ != nullptr) return true;
  if (left_out_++ == 0) warn(name_ + ": the disk is too slow: ticks are left out");
  command_.reset();  // it has to be said again
  return false;
}

void RecordingWriter::add(Topic topic) {
  chunk_->add(static_cast<std::uint16_t>(static_cast<unsigned>(topic) + 1U), sequence_, time_, body_);
}

void RecordingWriter::add(Topic topic, const nlohmann::json& message) {
  body_ = message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  add(topic);
}

void RecordingWriter::on_tick(const TickRecord& record) {
  if (thread_.failed()) return;
  time_ = static_cast<std::uint64_t>(nanoseconds(record.t));
  sequence_ = static_cast<std::uint32_t>(record.navigator.now());
  if (!begin(time_)) return;
  add_measurement(record.measurement);
  add_tick(record);
  add_command(record.navigator.command());
  for (const nlohmann::json& targets : std::exchange(arms_, {}))
    add(Topic::arms, targets);
  add_events(record);
  add_pushes(record.t);
  add_notes();
  if (record.navigator.now() % each_ == 0) add_estimates(record);
}

void RecordingWriter::add_measurement(const Measurement& m) {
  measured_.header.stamp = imu_.header.stamp = sole_.header.stamp = nanoseconds(m.t);
  measured_.position = m.q;
  measured_.velocity = m.dq;
  measured_.effort = m.torque;
  encode(body_, measured_);
  add(Topic::joint_states);
  imu_.orientation = ros::quaternion(m.imu.attitude);
  imu_.angular_velocity = m.imu.rate;
  imu_.linear_acceleration = m.imu.acceleration;
  encode(body_, imu_);
  add(Topic::imu);
  for (const Side side : kSides) {
    sole_.header.frame = side == Side::left ? "left_sole" : "right_sole";
    sole_.wrench = m.sole[side];
    encode(body_, sole_);
    add(side == Side::left ? Topic::sole_left : Topic::sole_right);
  }
  if (!perfect_ || !m.root) return;
  add(Topic::root, {{"position", vector_json(m.root->pose.p)},
                    {"attitude", vector_json(m.root->pose.R)},
                    {"velocity", vector_json(m.root->velocity)},
                    {"rate", vector_json(m.root->rate)}});
}

void RecordingWriter::add_tick(const TickRecord& record) {
  target_.header.stamp = static_cast<std::int64_t>(time_);
  target_.position = record.target.q.unaryExpr(&recorded_angle);
  encode(body_, target_);
  add(Topic::joint_targets);

  const Measurement& m = record.measurement;
  body_.clear();
  const auto to = std::back_inserter(body_);
  if (std::isfinite(m.age)) {
    fmt::format_to(to, "{{\"age\":{}", m.age);
  } else {
    fmt::format_to(to, "{{\"age\":null");
  }
  fmt::format_to(to, ",\"sum\":\"{}\"", checksum(record.target));
  // No quaternion gives each matrix to the last bit.
  const Mat3 shown = ros::rotation(imu_.orientation);
  if (!std::equal(shown.data(), shown.data() + 9, m.imu.attitude.data(), [](double a, double b) {
        return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
      })) {
    for (Eigen::Index i = 0; i < 9; ++i) {
      const auto bits = [i](const Mat3& R) { return std::bit_cast<std::uint64_t>(R.data()[i]); };
      fmt::format_to(to, "{}{}", i == 0 ? ",\"attitude\":[" : ",",
                     static_cast<std::int64_t>(bits(m.imu.attitude) - bits(shown)));
    }
    body_ += ']';
  }
  body_ += '}';
  add(Topic::tick);
}

void RecordingWriter::add_command(const Command& command) {
  if (command_ == command) return;
  command_ = command;
  add(Topic::command, to_json(command));
  ros::Joy joy;
  joy.header.stamp = static_cast<std::int64_t>(time_);
  for (const double axis : command.axes)
    joy.axes.push_back(static_cast<float>(axis));
  joy.axes.push_back(static_cast<float>(command.lift.left));
  joy.axes.push_back(static_cast<float>(command.lift.right));
  for (const Part part : kParts)
    joy.buttons.push_back(part == command.guide ? 1 : 0);
  for (const Recall recall : {Recall::retrace, Recall::home, Recall::stop})
    joy.buttons.push_back(recall == command.recall ? 1 : 0);
  encode(body_, joy);
  add(Topic::joy);
}

void RecordingWriter::add_events(const TickRecord& record) {
  if (!record.navigator.events().empty()) {
    for (const nlohmann::json& message : event_messages(record.navigator))
      add(Topic::events, message);
    if (find_event<Committed>(record.navigator.events()) != nullptr)
      add(Topic::segments, segment_message(record.navigator));
  }
  const bool fallen = record.truth != nullptr && record.truth->fallen;
  if (fallen && !std::exchange(fallen_, fallen)) add(Topic::falls, {{"fall", record.truth->fall}});
}

void RecordingWriter::add_pushes(double t) {
  std::erase_if(parameters_.pushes, [&](const Push& push) {
    if (push.t > t) return false;
    add(Topic::pushes, {{"impulse", vector_json(push.impulse)},
                        {"duration", push.duration},
                        {"on", push.hand ? to_string(hand(*push.hand)) : to_string(Part::trunk)}});
    return true;
  });
}

void RecordingWriter::add_notes() {
  for (const nlohmann::json& note : std::exchange(notes_, {}))
    add(Topic::link, note);
}

void RecordingWriter::add_estimates(const TickRecord& record) {
  const Navigator& nav = record.navigator;
  const Pose& anchor = nav.anchor();
  const State& state = nav.state();
  const MotionSample& plan = nav.sample();
  const auto in_world = [&](const Vec2& zmp) -> Vec2 {
    return (anchor * Vec3(zmp.x(), zmp.y(), plan.zmp_height)).head<2>();
  };
  body_ = fmt::format("{{\"segment\":{},\"phase\":\"{}\",\"guard\":\"{}\"", nav.segment(), to_string(nav.phase()),
                      to_string(nav.guard()));
  put_rounded(body_, "com", Vec3(anchor * state.com));
  put_rounded(body_, "zmp", in_world(nav.correction().zmp));
  put_rounded(body_, "zmp_plan", in_world(plan.zmp + nav.correction().com_offset));
  put_rounded(body_, "dcm_error", nav.dcm_error());
  const double heat = nav.thermometer().hottest().total;
  fmt::format_to(std::back_inserter(body_), ",\"heat\":{}}}", std::isfinite(heat) ? std::round(1e4 * heat) / 1e4 : 0.0);
  add(Topic::estimates);

  const Eigen::Quaterniond attitude(state.q[3], state.q[4], state.q[5], state.q[6]);
  const Pose root = anchor * Pose{state.q.head<3>(), attitude.toRotationMatrix()};
  root_.header.stamp = static_cast<std::int64_t>(time_);
  root_.translation = root.p.unaryExpr(&rounded);
  root_.rotation = ros::quaternion(root.R).unaryExpr(&rounded);
  encode(body_, root_);
  add(Topic::tf);
}

void RecordingWriter::on_plan(const PlanRecord& record) {
  if (chunk_ != nullptr && !thread_.failed()) offer_ = offer_message(record);
}

void RecordingWriter::on_arms(const ArmTargets& targets) {
  if (!thread_.failed()) arms_.push_back(to_json(targets));
}

void RecordingWriter::on_planning(PlanningEvent event) {
  if (chunk_ == nullptr || thread_.failed()) return;
  if (event == PlanningEvent::ask) {
    add(Topic::planner, {{"call", "ask"}});
  } else {
    add(Topic::planner, offer_.value_or(nlohmann::json{{"call", "offer"}}));
    offer_.reset();
  }
}

void RecordingWriter::note(const std::string& what, const std::string& text) {
  if (!thread_.failed()) notes_.push_back({{"what", what}, {"text", text}});
}

std::string RecordingWriter::close() {
  if (chunk_ != nullptr) add_notes();
  if (std::exchange(chunk_, nullptr) != nullptr) thread_.hand_over();
  const std::string why = thread_.close();
  if (!why.empty() || left_out_ == 0) return why;
  return fmt::format("{}: {} ticks were left out, as the disk was too slow", name_, left_out_);
}

}  // namespace baton
