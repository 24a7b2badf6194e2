#include "baton/proving/tally.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

/// Non-finite values become null, as JSON cannot express them.
nlohmann::json number(double x) {
  return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(nullptr);
}

double number(const JsonReader& read) {
  return read.json().is_null() ? std::numeric_limits<double>::quiet_NaN() : read.number();
}

long count(const JsonReader& read) {
  return read.integer(0, 1000000000000000);
}

std::map<std::string, long> counts(const JsonReader& read) {
  if (!read.json().is_object()) read.fail("an object of counts");
  std::map<std::string, long> all;
  for (const auto& [name, value] : read.json().items())
    all[name] = count(read.at(name.c_str()));
  return all;
}

/// P(X ≤ k) of the binomial distribution.
double binomial_tail(long k, long n, double p) {
  if (k >= n || p <= 0.0) return 1.0;
  if (p >= 1.0) return 0.0;
  const auto N = static_cast<double>(n);
  double sum = 0.0;
  double term = N * std::log1p(-p);  // log of the probability of i
  for (long i = 0; i <= k; ++i) {
    sum += std::exp(term);
    term += std::log((N - static_cast<double>(i)) / static_cast<double>(i + 1)) + std::log(p) - std::log1p(-p);
  }
  return sum;
}

}  // namespace

double failure_rate_95(long failures, long trials) {
  if (trials <= 0 || failures >= trials) return 1.0;
  if (failures <= 0) return -std::expm1(std::log(0.05) / static_cast<double>(trials));
  double lo = static_cast<double>(failures) / static_cast<double>(trials);
  double hi = 1.0;
  while (hi - lo > 1e-12 * hi) {
    const double p = 0.5 * (lo + hi);
    if (p == lo || p == hi) break;
    (binomial_tail(failures, trials, p) > 0.05 ? lo : hi) = p;
  }
  return hi;
}

void Tally::add(const Tally& other) {
  episodes += other.episodes;
  ticks += other.ticks;
  deflected += other.deflected;
  segments += other.segments;
  shrunk += other.shrunk;
  let_go += other.let_go;
  given += other.given;
  moved += other.moved;
  travel += other.travel;
  failures += other.failures;
  arms.driven += other.arms.driven;
  arms.on_target += other.arms.on_target;
  retrace.tried += other.retrace.tried;
  retrace.arrived += other.retrace.arrived;
  retrace.refused += other.retrace.refused;
  retrace.worst_m = std::max(retrace.worst_m, other.retrace.worst_m);
  retrace.worst_rad = std::max(retrace.worst_rad, other.retrace.worst_rad);
  for (const auto& [reason, count] : other.refused)
    refused[reason] += count;
  for (const auto& [kind, count] : other.bad)
    bad[kind] += count;
  for (const Failure& failure : other.listed) {
    if (listed.size() < kListed) listed.push_back(failure);
  }
}

nlohmann::json Tally::json() const {
  nlohmann::json list = nlohmann::json::array();
  for (const Failure& f : listed) {
    list.push_back({{"kind", f.kind},
                    {"episode", f.episode},
                    {"t", f.t},
                    {"value", number(f.value)},
                    {"limit", number(f.limit)},
                    {"where", f.where}});
  }
  return {{"episodes", episodes},
          {"ticks", ticks},
          {"deflected_ticks", deflected},
          {"segments", segments},
          {"shrunk", shrunk},
          {"let_go", let_go},
          {"refused", nlohmann::json(refused)},
          {"commands", {{"given", given}, {"moved", moved}}},
          {"travel_m", travel},
          {"arms", {{"driven_ticks", arms.driven}, {"on_target_ticks", arms.on_target}}},
          {"retrace",
           {{"tried", retrace.tried},
            {"arrived", retrace.arrived},
            {"refused", retrace.refused},
            {"worst_m", retrace.worst_m},
            {"worst_rad", retrace.worst_rad}}},
          {"violations", nlohmann::json(bad)},
          {"failures", failures},
          {"first_failures", list}};
}

Tally Tally::from_json(const JsonReader& read) {
  Tally tally;
  tally.episodes = count(read.at("episodes"));
  tally.ticks = count(read.at("ticks"));
  tally.deflected = count(read.at("deflected_ticks"));
  tally.segments = count(read.at("segments"));
  tally.shrunk = count(read.at("shrunk"));
  tally.let_go = count(read.at("let_go"));
  tally.refused = counts(read.at("refused"));
  tally.given = count(read.at("commands").at("given"));
  tally.moved = count(read.at("commands").at("moved"));
  tally.travel = read.at("travel_m").number();
  tally.arms = {count(read.at("arms").at("driven_ticks")), count(read.at("arms").at("on_target_ticks"))};
  const JsonReader back = read.at("retrace");
  tally.retrace = {count(back.at("tried")), count(back.at("arrived")), count(back.at("refused")),
                   back.at("worst_m").number(), back.at("worst_rad").number()};
  tally.bad = counts(read.at("violations"));
  tally.failures = count(read.at("failures"));
  const JsonReader listed = read.at("first_failures");
  if (listed.json() == nlohmann::json::array()) return tally;
  for (const JsonReader& f : listed.list()) {
    tally.listed.push_back({f.at("kind").text(), count(f.at("episode")), f.at("t").number(), number(f.at("value")),
                            number(f.at("limit")), f.at("where").text()});
  }
  return tally;
}

}  // namespace baton
