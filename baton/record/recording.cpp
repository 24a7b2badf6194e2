#include "baton/record/recording.hpp"

#include <fmt/format.h>

#include <cstring>
#include <limits>

#include "baton/input/json_reader.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"
#include "baton/record/json.hpp"
#include "baton/record/output_file.hpp"

namespace baton {
namespace {

using Json = nlohmann::json;

constexpr int kVersion = 2;
constexpr std::size_t kLongest = 1U << 20U;  ///< longest line [bytes]; a tick takes about 2 kB

Json wrench_json(const Wrench& w) {
  return {vector_json(w.force), vector_json(w.moment)};
}

Json command_json(const Command& c) {
  return {{"guide", to_string(c.guide)},
          {"axes", vector_json(c.axes)},
          {"lift", {c.lift.left, c.lift.right}},
          {"recall", static_cast<int>(c.recall)}};
}

Command command_in(const JsonReader& read) {
  Command c;
  const std::string guide = read.at("guide").one_of({"left_foot", "right_foot", "left_hand", "right_hand", "trunk"});
  for (const Part part : kParts) {
    if (to_string(part) == guide) c.guide = part;
  }
  c.axes = read.at("axes").vector(6);
  const VecX lift = read.at("lift").vector(2);
  c.lift = {lift[0], lift[1]};
  c.recall = static_cast<Recall>(read.at("recall").integer(0, 3));
  return c;
}

Json measurement_json(const Measurement& m) {
  Json json = {{"t", m.t},
               {"age", std::isfinite(m.age) ? m.age : 0.0},
               {"q", vector_json(m.q)},
               {"dq", vector_json(m.dq)},
               {"torque", vector_json(m.torque)},
               {"imu", {vector_json(m.imu.attitude), vector_json(m.imu.rate), vector_json(m.imu.acceleration)}},
               {"sole", {wrench_json(m.sole.left), wrench_json(m.sole.right)}}};
  if (m.root) {
    json["root"] = {vector_json(m.root->pose.p), vector_json(m.root->pose.R), vector_json(m.root->velocity),
                    vector_json(m.root->rate)};
  }
  return json;
}

/// `null` stands for what is not a finite number.
VecX reading_in(const JsonReader& read, Eigen::Index size) {
  return read.vector(size, true);
}

Mat3 matrix_in(const JsonReader& read) {
  return Eigen::Map<const Mat3>(reading_in(read, 9).data());
}

Wrench wrench_in(const JsonReader& read) {
  const std::vector<JsonReader> parts = read.list(2);
  return {reading_in(parts[0], 3), reading_in(parts[1], 3)};
}

Measurement measurement_in(const JsonReader& read, Eigen::Index joints, bool need_root) {
  Measurement m;
  m.t = read.at("t").number();
  if (read.has("age")) m.age = read.at("age").number();
  m.q = reading_in(read.at("q"), joints);
  m.dq = reading_in(read.at("dq"), joints);
  const JsonReader torque = read.at("torque");
  if (torque.json() != Json::array()) m.torque = reading_in(torque, joints);  // empty: not measured
  const std::vector<JsonReader> imu = read.at("imu").list(3);
  m.imu = {matrix_in(imu[0]), reading_in(imu[1], 3), reading_in(imu[2], 3)};
  const std::vector<JsonReader> sole = read.at("sole").list(2);
  m.sole = {wrench_in(sole[0]), wrench_in(sole[1])};
  if (need_root || read.has("root")) {
    const std::vector<JsonReader> root = read.at("root").list(4);
    m.root =
        RootMeasurement{{reading_in(root[0], 3), matrix_in(root[1])}, reading_in(root[2], 3), reading_in(root[3], 3)};
  }
  return m;
}

}  // namespace

std::string checksum(const JointTarget& target) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a
  const auto add = [&hash](const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i)
      hash = (hash ^ bytes[i]) * 0x100000001b3ULL;
  };
  for (const VecX* v : {&target.q, &target.dq, &target.ddq, &target.tau, &target.q_correction})
    add(v->data(), static_cast<std::size_t>(v->size()) * sizeof(double));
  const std::array<unsigned char, 2> contact{target.contact.left, target.contact.right};
  add(contact.data(), contact.size());
  return fmt::format("{:016x}", hash);
}

HealthChanges health_changes(std::span<const Event> events) {
  HealthChanges changes;
  for (const Event& event : events) {
    if (const auto* changed = std::get_if<SensorChanged>(&event))
      changes.emplace(to_string(changed->sensor), to_string(changed->health));
  }
  return changes;
}

RecordingWriter::RecordingWriter(const std::filesystem::path& file, const Json& head)
    : file_(file), out_(open_stream(file, "--record")) {
  Json first = {{"baton_recording", kVersion}};
  first.update(head);
  out_ << first.dump() << '\n' << std::flush;
}

void RecordingWriter::on_tick(const TickRecord& record) {
  flush();
  Json line = {{"m", measurement_json(record.measurement)},
               {"target", vector_json(record.target.q)},
               {"sum", checksum(record.target)}};
  const Command& command = record.navigator.command();
  if (first_ || !(command == command_)) line["c"] = command_json(command);
  if (record.truth != nullptr && record.truth->fallen) line["fallen"] = true;
  const HealthChanges sensors = health_changes(record.navigator.events());
  if (!sensors.empty()) line["sensors"] = sensors;
  command_ = command;
  first_ = false;
  tick_ = line.dump();
}

void RecordingWriter::on_planning(PlanningEvent event) {
  events_ += fmt::format("{}\"{}\"", events_.empty() ? "" : ",", event == PlanningEvent::ask ? "ask" : "offer");
}

void RecordingWriter::flush() {
  if (tick_.empty()) return;
  if (!events_.empty()) {
    tick_.pop_back();
    tick_ += ",\"events\":[" + events_ + "]}";
  }
  out_ << tick_ << '\n';
  tick_.clear();
  events_.clear();
}

void RecordingWriter::close() {
  flush();
  close_stream(out_, file_, "--record");
}

RecordingReader::RecordingReader(const std::filesystem::path& file) : file_(file) {
  check_input(file, "recording", std::numeric_limits<std::uintmax_t>::max());
  in_.open(file);
  std::string line;
  if (!read_line(line)) throw InputError(fmt::format("recording {}: cannot be read, or is empty", file.string()));
  const Json json = parse_json(line, place());
  const JsonReader read(json, place());
  if (read.at("baton_recording").json() != kVersion)
    read.at("baton_recording").fail(fmt::format("{}, the version that this program reads", kVersion));
  static_cast<void>(read.at("on").one_of({"sim", "ideal", "real"}));
  static_cast<void>(read.at("seed").integer(std::numeric_limits<long>::min(), std::numeric_limits<long>::max()));
  head_ = {read.at("robot").text(),
           read.at("world").text(),
           read.at("duration").one_of({"paper", "search"}),
           read.at("gait").one_of({"stop", "flow"}),
           read.at("on_limit").one_of({"discard", "shrink"}),
           read.at("state").one_of({"sensors", "torques", "perfect"}),
           read.at("drive").one_of({"torque", "pd", "stiff"}),
           {}};
  if (!read.has("start")) return;
  for (const JsonReader& value : read.at("start").list())
    head_.start.push_back(value.number());
}

std::string RecordingReader::place() const {
  return fmt::format("recording {}: line {}", file_.string(), line_);
}

bool RecordingReader::read_line(std::string& line) {
  line.clear();
  ++line_;
  for (int c = in_.rdbuf()->sbumpc(); c != '\n'; c = in_.rdbuf()->sbumpc()) {
    whole_ = c != std::char_traits<char>::eof();
    if (!whole_) break;
    line += static_cast<char>(c);
    if (line.size() > kLongest) {
      throw InputError(fmt::format("{}: has more than {} bytes: not a line of a recording", place(), kLongest));
    }
  }
  return whole_ || !line.empty();
}

std::optional<RecordedTick> RecordingReader::next(Eigen::Index joints) {
  const bool first = line_ == 1;
  std::string line;
  const bool there = read_line(line);
  const bool cut = !whole_ && !Json::accept(line);  // the process ended while writing it
  if (!there || cut) {
    if (first) throw InputError(fmt::format("recording {}: holds no ticks", file_.string()));
    return std::nullopt;
  }
  const Json json = parse_json(line, place());
  const JsonReader read(json, place());
  RecordedTick tick;
  tick.fallen = read.has("fallen") && read.at("fallen").boolean();
  tick.measurement = measurement_in(read.at("m"), joints, head_.state == "perfect");
  if (first || read.has("c")) command_ = command_in(read.at("c"));
  tick.command = command_;
  tick.target = read.at("target").vector(joints, tick.fallen);
  tick.checksum = read.at("sum").text();
  if (read.has("sensors")) {
    const JsonReader changes = read.at("sensors");
    for (const Sensor sensor : kSensors) {
      const std::string name(to_string(sensor));
      if (changes.has(name.c_str())) tick.sensors[name] = changes.at(name.c_str()).one_of({"good", "bridged", "lost"});
    }
    if (!changes.json().is_object() || changes.json().size() != tick.sensors.size())
      changes.fail("an object whose keys are sensors");
  }
  if (read.has("events")) {
    for (const JsonReader& event : read.at("events").list())
      tick.events.push_back(event.one_of({"ask", "offer"}) == "ask" ? PlanningEvent::ask : PlanningEvent::answer);
  }
  return tick;
}

}  // namespace baton
