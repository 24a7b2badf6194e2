/// The table of reasons against its copies: what the page and docs/refusals.md say of each.
#include "baton/motion/refusal.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace baton {
namespace {

std::ifstream source(const std::string& file) {
  return std::ifstream(std::string(BATON_SOURCE_DIR) + "/" + file);
}

TEST(Reason, HasANameAndATextOfItsOwn) {
  std::set<std::string_view> names;
  std::set<std::string_view> texts;
  for (const ReasonInfo& row : kReasonTable) {
    names.insert(row.name);
    texts.insert(row.text);
    EXPECT_EQ(row.unit == Unit::none, row.bound == Bound::none) << row.name;
    EXPECT_FALSE(row.text.empty()) << row.name;
  }
  EXPECT_EQ(names.size(), kReasons);
  EXPECT_EQ(texts.size(), kReasons);
}

TEST(Reason, ThePageHasTheSameTable) {
  nlohmann::json table;
  for (const ReasonInfo& row : kReasonTable) {
    table[std::string(row.name)] = {{"unit", to_string(row.unit)}, {"bound", to_string(row.bound)}, {"text", row.text}};
  }
  EXPECT_EQ(nlohmann::json::parse(source("web/src/reasons.json")), table) << "it should be\n" << table.dump(2);
}

/// What a unit is called in the document.
std::string symbol(Unit unit) {
  switch (unit) {
    case Unit::length:
      return "[m]";
    case Unit::angle:
      return "[rad]";
    case Unit::speed:
      return "[rad/s]";
    case Unit::acceleration:
      return "[rad/s²]";
    default:
      return "";
  }
}

TEST(Reason, TheDocumentHasARowForEachAndForNothingElse) {
  std::ifstream in = source("docs/refusals.md");
  std::map<std::string, std::string> numbers;  // the column of value and limit
  std::string by_time;                         // the paragraph below the tables
  int rows = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("| `")) {
      ++rows;
      const std::string name = line.substr(3, line.find('`', 3) - 3);
      const std::size_t begin = line.find(" | ", line.find(" | ") + 1) + 3;
      numbers[name] = line.substr(begin, line.find(" | ", begin) - begin);
    }
    if (line.starts_with("`zmp`") || !by_time.empty()) by_time += line + " ";
  }
  EXPECT_EQ(rows, static_cast<int>(kReasons));
  for (const ReasonInfo& row : kReasonTable) {
    const auto found = numbers.find(std::string(row.name));
    ASSERT_NE(found, numbers.end()) << row.name;
    const auto says = [&](const std::string& text) { return found->second.find(text) != std::string::npos; };
    EXPECT_EQ(says("["), !symbol(row.unit).empty()) << row.name << ": " << found->second;
    EXPECT_TRUE(says(symbol(row.unit))) << row.name << ": " << found->second;
    for (const Bound bound : {Bound::at_least, Bound::at_most, Bound::range})
      EXPECT_EQ(says(std::string(to_string(bound))), row.bound == bound) << row.name << ": " << found->second;
    const bool mends = by_time.find('`' + std::string(row.name) + '`') != std::string::npos;
    EXPECT_EQ(mends, row.mends_with_time) << row.name;
  }
}

TEST(Reason, ACauseHandsOnItsPartAndItsNumbers) {
  for (const ReasonInfo& row : kReasonTable) {
    const Refusal behind{row.reason, Part::left_foot, 0.3, 0.2, "forward", 1.0};
    EXPECT_EQ(place(behind), "forward");
    const Refusal refusal = refusal_by(Reason::no_landing, behind);
    EXPECT_EQ(refusal.reason, Reason::no_landing);
    EXPECT_EQ(refusal.part, behind.part);
    EXPECT_EQ(refusal.value, behind.value);
    EXPECT_EQ(refusal.limit, behind.limit);
    EXPECT_EQ(refusal.cause, row.reason);
    EXPECT_EQ(place(refusal), row.name);
  }
}

}  // namespace
}  // namespace baton
