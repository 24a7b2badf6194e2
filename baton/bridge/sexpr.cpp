#include "baton/bridge/sexpr.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string>

namespace baton::bridge {
namespace {

constexpr std::size_t kDeepest = 32;
constexpr std::string_view kSpace = " \t\r\n";
constexpr std::string_view kBorders = " \t\r\n()";

/// As a part of a line that does nothing to a terminal.
std::string quoted(std::string_view text) {
  constexpr std::size_t kShown = 40;
  std::string shown(text.substr(0, kShown));
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
  }
  return fmt::format("'{}{}'", shown, text.size() > kShown ? "..." : "");
}

}  // namespace

const SExpr& SExpr::at(std::size_t index) const {
  if (index < list.size()) return list[index];
  throw SExprError(list.empty() ? fmt::format("{} in place of a list", quoted(atom))
                                : fmt::format("a list {} of {} elements: must have more than {}",
                                              quoted(list.front().atom), list.size(), index));
}

double SExpr::number() const {
  double value = 0.0;
  const auto [end, error] = std::from_chars(atom.data(), atom.data() + atom.size(), value);
  if (atom.empty() || error != std::errc() || end != atom.data() + atom.size() || !std::isfinite(value))
    throw SExprError(fmt::format("{} in place of a finite number", atom.empty() ? "a list" : quoted(atom)));
  return value;
}

const SExpr& SExpr::find(std::string_view head) const {
  for (const SExpr& element : list) {
    if (element.is(head)) return element;
  }
  throw SExprError(fmt::format("no ({} ...) in {}", head, list.empty() ? quoted(atom) : quoted(list.front().atom)));
}

std::vector<SExpr> parse_sexprs(std::string_view text) {
  std::vector<std::vector<SExpr>> open(1);  // the lists that are not closed yet, the outermost first
  std::size_t at = 0;
  while ((at = text.find_first_not_of(kSpace, at)) != std::string_view::npos) {
    if (text[at] == '(') {
      if (open.size() > kDeepest) throw SExprError(fmt::format("brackets are nested more than {} deep", kDeepest));
      open.emplace_back();
      ++at;
    } else if (text[at] == ')') {
      if (open.size() == 1) throw SExprError("a bracket is closed that is not open");
      SExpr closed{{}, std::move(open.back())};
      open.pop_back();
      open.back().push_back(std::move(closed));
      ++at;
    } else {
      const std::size_t end = std::min(text.find_first_of(kBorders, at), text.size());
      open.back().push_back({text.substr(at, end - at), {}});
      at = end;
    }
  }
  if (open.size() > 1) throw SExprError("a bracket is not closed");
  return std::move(open.front());
}

}  // namespace baton::bridge
