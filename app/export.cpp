#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/export_plots.hpp"
#include "app/outputs.hpp"
#include "app/replayer.hpp"
#include "baton/mcap/reader.hpp"
#include "baton/model/error.hpp"
#include "baton/record/message_columns.hpp"
#include "baton/record/output_file.hpp"

namespace baton::app {
namespace {

namespace fs = std::filesystem;

/// Calls `use(message, topic, columns)` for each message that is understood.
template <typename Use>
void for_each_row(const fs::path& file, Use use) {
  mcap::Reader reader(file, "recording");
  while (const std::optional<mcap::Message> message = reader.next()) {
    if (interrupted) throw std::runtime_error("interrupted");
    const mcap::Channel& channel = reader.channels().at(message->channel);
    const auto schema = reader.schemas().find(channel.schema);
    try {
      use(*message, channel.topic,
          columns_of(channel, schema != reader.schemas().end() ? &schema->second : nullptr, message->data));
    } catch (const mcap::Malformed& why) {
      throw InputError(fmt::format("{}: {}: {}", reader.place(), channel.topic, why.what()));
    }
  }
}

/// "/sole/left" → "sole_left.csv"
std::string table_name(const std::string& topic) {
  std::string name;
  for (const char c : topic) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.';
    if (plain || !name.empty()) name += plain ? c : '_';
  }
  return name + ".csv";
}

std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text)
    quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

/// The table of a channel. Messages need not have the same members.
struct Table {
  std::vector<std::string> names;
  std::map<std::string, std::size_t> places;
  fs::path file;
  std::ofstream out;
};

void export_channels(const fs::path& recording, const fs::path& folder) {
  std::map<std::string, Table> tables;
  for_each_row(recording, [&](const auto& /*message*/, const std::string& topic, const std::vector<Column>& columns) {
    if (columns.empty()) return;
    Table& table = tables[topic];
    for (const auto& [name, value] : columns) {
      if (table.places.emplace(name, table.names.size()).second) table.names.push_back(name);
    }
  });
  for (auto& [topic, table] : tables) {
    table.file = folder / table_name(topic);
    table.out = open_stream(table.file, "--csv");
    table.out << "t,tick";
    for (const std::string& name : table.names)
      table.out << ',' << cell(name);
    table.out << '\n';
  }
  std::vector<std::string> row;
  for_each_row(recording,
               [&](const mcap::Message& message, const std::string& topic, const std::vector<Column>& columns) {
                 const auto found = tables.find(topic);  // a file that is still recorded may have more by now
                 if (columns.empty() || found == tables.end()) return;
                 Table& table = found->second;
                 row.assign(table.names.size(), "");
                 for (const auto& [name, value] : columns) {
                   if (const auto place = table.places.find(name); place != table.places.end())
                     row[place->second] = value;
                 }
                 table.out << fmt::format("{:.6f},{}", 1e-9 * static_cast<double>(message.log_time), message.sequence);
                 for (const std::string& value : row)
                   table.out << ',' << cell(value);
                 table.out << '\n';
               });
  for (auto& [topic, table] : tables)
    close_stream(table.out, table.file, "--csv");
}

/// The run's trace, by replaying it; without what only a simulator knows.
void export_trace(const fs::path& recording, const fs::path& folder) {
  Replayer run(recording, false);
  Trace trace(run.robot(), folder / "trace.csv", "--csv");
  const double period = run.robot().profile().tick.period;
  while (run.step()) {
    if (interrupted) throw std::runtime_error("interrupted");
    const Navigator& navigator = run.navigator();
    trace.on_tick(
        {static_cast<double>(navigator.now()) * period, navigator, run.tick().measurement, nullptr, run.target()});
  }
  if (run.gap() != 0) spdlog::warn("trace.csv ends at a gap of {} ticks", run.gap());
  trace.close();
}

void export_plots(const fs::path& recording, const fs::path& folder) {
  std::uint64_t end = 0;
  std::map<std::string, std::set<std::string>> names;
  for_each_row(recording,
               [&](const mcap::Message& message, const std::string& topic, const std::vector<Column>& columns) {
                 end = std::max(end, message.log_time);
                 for (const auto& [name, value] : columns)
                   names[topic].insert(name);
               });
  ExportPlots plots(names, 1e-9 * static_cast<double>(end));
  for_each_row(recording,
               [&](const mcap::Message& message, const std::string& topic, const std::vector<Column>& columns) {
                 const double t = 1e-9 * static_cast<double>(message.log_time);
                 for (const auto& [name, value] : columns)
                   plots.add(topic, name, t, value);
               });
  plots.save(folder);
}

}  // namespace

int export_recording(const ExportOptions& o) {
  if (!o.csv && !o.plots) throw InputError("export: --csv DIR or --plots DIR is missing: where to write what");
  if (o.csv) {
    make_folder(*o.csv, "--csv");
    export_channels(o.recording, *o.csv);
    try {
      export_trace(o.recording, *o.csv);
    } catch (const InputError& error) {
      spdlog::warn("no whole trace.csv, as the run cannot be replayed: {}", error.what());
    }
  }
  if (o.plots) {
    make_folder(*o.plots, "--plots");
    export_plots(o.recording, *o.plots);
  }
  return kDone;
}

}  // namespace baton::app
