#include "app/robot_recording.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "app/options.hpp"
#include "baton/link/engage.hpp"
#include "baton/model/error.hpp"
#include "baton/record/json.hpp"

namespace baton::app {

RobotRecording::RobotRecording(const RobotOptions& options, const RobotModel& model, const World& world,
                               std::filesystem::path folder, std::map<std::string, std::string> settings)
    : options_(options),
      folder_(std::move(folder)),
      settings_(std::move(settings)),
      origins_(origins_of(options.robot, model, world)) {
  make_folder(folder_, "--record");
}

void RobotRecording::begin(link::Onboard& onboard, const link::NavigationOptions& navigation) {
  end();
  Session& session = onboard.session();
  const RobotModel& model = session.model();
  nlohmann::json head =
      recording_head(options_.robot, options_.world, options_.seed, navigation.modes, navigation.source, model);
  head["end"] = "robot";
  head.update(nlohmann::json(settings_));
  if (navigation.hangs) head["hangs"] = true;
  const VecX& start = session.start().q;
  if (!link::in_stance(model, start.tail(model.nv() - 6))) head["start"] = vector_json(start);
  std::filesystem::path file;
  do
    file = folder_ / fmt::format("{:03}.mcap", ++number_);
  while (std::filesystem::exists(file));
  try {
    writer_ = recording_of(session, file, std::move(head), origins_, options_.real_time || !options_.sim, {});
  } catch (const InputError& error) {
    spdlog::warn("{}: this run is not recorded", error.what());
    return;
  }
  session.add(*this);
  spdlog::info("recording to {}", file.string());
}

void RobotRecording::end() {
  std::erase_if(closing_, [](const std::future<void>& closed) {
    return closed.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  });
  if (!writer_) return;
  closing_.push_back(std::async(std::launch::async, [writer = std::move(writer_)] {
    const std::string incomplete = writer->close();
    if (!incomplete.empty()) spdlog::warn("the recording is not complete: {}", incomplete);
  }));
  writer_ = nullptr;
}

void RobotRecording::log(const std::string& text) {
  if (writer_) writer_->note("log", text);
}

void RobotRecording::on_tick(const TickRecord& record) {
  if (writer_) writer_->on_tick(record);
}

void RobotRecording::on_plan(const PlanRecord& record) {
  if (writer_) writer_->on_plan(record);
}

void RobotRecording::on_planning(PlanningEvent event) {
  if (writer_) writer_->on_planning(event);
}

void RobotRecording::on_arms(const ArmTargets& targets) {
  if (writer_) writer_->on_arms(targets);
}

}  // namespace baton::app
