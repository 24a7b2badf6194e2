#include "baton/record/recording.hpp"

#include <fmt/format.h>

#include <cstring>
#include <limits>

#include "baton/model/error.hpp"
#include "baton/record/json.hpp"

namespace baton {
namespace {

using Json = nlohmann::json;

constexpr int kVersion = 2;

template <typename Matrix>
void get(const Json& json, Matrix& m) {
  const auto v = json.get<std::vector<double>>();
  if constexpr (Matrix::SizeAtCompileTime == Eigen::Dynamic) m.resize(static_cast<Eigen::Index>(v.size()));
  if (static_cast<Eigen::Index>(v.size()) != m.size()) throw std::invalid_argument("a list has not the length it must");
  std::copy(v.begin(), v.end(), m.data());
}

Json wrench_json(const Wrench& w) {
  return {vector_json(w.force), vector_json(w.moment)};
}

void get(const Json& json, Wrench& w) {
  get(json.at(0), w.force);
  get(json.at(1), w.moment);
}

Json command_json(const Command& c) {
  return {{"guide", to_string(c.guide)},
          {"axes", vector_json(c.axes)},
          {"lift", {c.lift.left, c.lift.right}},
          {"recall", static_cast<int>(c.recall)}};
}

Command command_of(const Json& json) {
  Command c;
  const auto name = json.at("guide").get<std::string>();
  for (const Part part : kParts) {
    if (to_string(part) == name) c.guide = part;
  }
  get(json.at("axes"), c.axes);
  c.lift = {json.at("lift").at(0).get<double>(), json.at("lift").at(1).get<double>()};
  c.recall = static_cast<Recall>(json.at("recall").get<int>());
  return c;
}

Json measurement_json(const Measurement& m) {
  Json json = {{"t", m.t},
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

Measurement measurement_of(const Json& json) {
  Measurement m;
  m.t = json.at("t").get<double>();
  get(json.at("q"), m.q);
  get(json.at("dq"), m.dq);
  get(json.at("torque"), m.torque);
  get(json.at("imu").at(0), m.imu.attitude);
  get(json.at("imu").at(1), m.imu.rate);
  get(json.at("imu").at(2), m.imu.acceleration);
  get(json.at("sole").at(0), m.sole.left);
  get(json.at("sole").at(1), m.sole.right);
  if (json.contains("root")) {
    const Json& root = json.at("root");
    m.root.emplace();
    get(root.at(0), m.root->pose.p);
    get(root.at(1), m.root->pose.R);
    get(root.at(2), m.root->velocity);
    get(root.at(3), m.root->rate);
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
  for (const VecX* v : {&target.q, &target.dq, &target.ddq, &target.tau, &target.shift})
    add(v->data(), static_cast<std::size_t>(v->size()) * sizeof(double));
  const std::array<unsigned char, 2> contact{target.contact.left, target.contact.right};
  add(contact.data(), contact.size());
  return fmt::format("{:016x}", hash);
}

RecordingWriter::RecordingWriter(const std::filesystem::path& file, const Json& head) : out_(file) {
  Json first = {{"baton_recording", kVersion}};
  first.update(head);
  out_ << first.dump() << '\n' << std::flush;
  if (!out_) throw InputError(fmt::format("--record {}: cannot be written", file.string()));
}

void RecordingWriter::add(const TickRecord& record, bool fallen) {
  flush();
  Json line = {{"m", measurement_json(record.measurement)},
               {"target", vector_json(record.target.q)},
               {"sum", checksum(record.target)}};
  const Command& command = record.navigator.command();
  if (first_ || !(command == command_)) line["c"] = command_json(command);
  if (fallen) line["fallen"] = true;
  command_ = command;
  first_ = false;
  tick_ = line.dump();
}

void RecordingWriter::add(PlanningEvent event) {
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

bool RecordingWriter::close() {
  flush();
  out_.close();
  return out_.good();
}

RecordingReader::RecordingReader(const std::filesystem::path& file) : file_(file), in_(file) {
  std::string line;
  if (!std::getline(in_, line)) throw InputError(fmt::format("recording {}: cannot be read", file.string()));
  head_ = Json::parse(line, nullptr, false);
  if (!head_.is_object() || head_.value("baton_recording", 0) != kVersion) {
    throw InputError(fmt::format("recording {}: is not one of version {}", file.string(), kVersion));
  }
}

std::optional<RecordedTick> RecordingReader::next() {
  std::string line;
  if (!std::getline(in_, line)) return std::nullopt;
  ++line_;
  const bool whole = !in_.eof();
  try {
    const Json json = Json::parse(line);
    RecordedTick tick;
    tick.measurement = measurement_of(json.at("m"));
    if (json.contains("c")) command_ = command_of(json.at("c"));
    tick.command = command_;
    tick.fallen = json.value("fallen", false);
    tick.checksum = json.at("sum").get<std::string>();
    if (json.contains("events")) {
      for (const Json& event : json.at("events")) {
        tick.events.push_back(event.get<std::string>() == "ask" ? PlanningEvent::ask : PlanningEvent::offer);
      }
    }
    return tick;
  } catch (const std::exception& error) {
    if (!whole) return std::nullopt;  // the process ended in the middle of it
    throw InputError(fmt::format("recording {}, line {}: {}", file_.string(), line_, error.what()));
  }
}

}  // namespace baton
