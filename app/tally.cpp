#include "app/tally.hpp"

#include <algorithm>
#include <cmath>

namespace baton::app {
namespace {

/// Not finite is null, as JSON has no word for it.
nlohmann::json number(double x) {
  return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(nullptr);
}

double number(const nlohmann::json& x) {
  return x.is_null() ? std::numeric_limits<double>::quiet_NaN() : x.get<double>();
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

Tally Tally::from_json(const nlohmann::json& json) {
  Tally tally;
  json.at("episodes").get_to(tally.episodes);
  json.at("ticks").get_to(tally.ticks);
  json.at("deflected_ticks").get_to(tally.deflected);
  json.at("segments").get_to(tally.segments);
  json.at("shrunk").get_to(tally.shrunk);
  json.at("let_go").get_to(tally.let_go);
  json.at("refused").get_to(tally.refused);
  json.at("commands").at("given").get_to(tally.given);
  json.at("commands").at("moved").get_to(tally.moved);
  json.at("travel_m").get_to(tally.travel);
  const nlohmann::json& back = json.at("retrace");
  tally.retrace = {back.at("tried").get<long>(), back.at("arrived").get<long>(), back.at("refused").get<long>(),
                   back.at("worst_m").get<double>(), back.at("worst_rad").get<double>()};
  json.at("violations").get_to(tally.bad);
  json.at("failures").get_to(tally.failures);
  for (const auto& f : json.at("first_failures")) {
    tally.listed.push_back({f.at("kind").get<std::string>(), f.at("episode").get<long>(), f.at("t").get<double>(),
                            number(f.at("value")), number(f.at("limit")), f.at("where").get<std::string>()});
  }
  return tally;
}

}  // namespace baton::app
