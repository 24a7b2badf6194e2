#include "baton/proving/eyes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace baton {
namespace {

constexpr double kRemembered = 1.0;  ///< to foresee how a motion goes on [s]

Place place(const Vec3& p, double yaw = 0.0) {
  return {p.x(), p.y(), p.z(), yaw};
}

}  // namespace

Eyes::Parameters Eyes::Parameters::with_error(double error) {
  Parameters parameters;
  parameters.yaw_error *= error / parameters.error;
  parameters.error = error;
  return parameters;
}

Eyes::Eyes(const RobotModel& robot, std::uint64_t seed, const Parameters& parameters)
    : parameters_(parameters),
      period_(robot.profile().tick.period),
      delay_(static_cast<std::size_t>(std::lround(parameters.reaction / period_))),
      kept_(static_cast<std::size_t>(std::lround(kRemembered / period_))),
      random_(seed),
      kinematics_(robot) {}

Sight Eyes::truth(const Truth& truth) {
  kinematics_.set(truth.q);
  Sight sight;
  for (const Side side : kSides)
    sight.sole[side] = place(kinematics_.sole(side).p, yaw_of(kinematics_.sole(side).R));
  sight.trunk = place(kinematics_.com(), yaw_of(kinematics_.trunk().R));
  sight.hand = place(kinematics_.hand(Side::left).p);
  sight.shoulder = place(kinematics_.shoulder(Side::left));
  return sight;
}

const Seen* Eyes::look(const Operator::View& view) {
  if (view.truth == nullptr) throw std::logic_error("a robot that has no truth cannot be seen from outside");
  const double kept = error_ ? std::exp(-period_ / parameters_.correlation_time) : 0.0;
  const double fresh = std::sqrt(1.0 - kept * kept);
  if (!error_) error_.emplace();
  Seen now{truth(*view.truth), page_.read(view)};
  const std::array<Place*, 5> errors = error_->all();
  const std::array<Place*, 5> places = now.sight.all();
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (int k = 0; k < 4; ++k) {
      const double sigma = k < 3 ? parameters_.error : parameters_.yaw_error;
      double& error = (*errors[i])[k];
      error = kept * error + fresh * sigma * normal_(random_);
      (*places[i])[k] += error;
    }
  }
  seen_.push_back(std::move(now));
  if (seen_.size() > delay_ + kept_ + 1) seen_.pop_front();
  return seen_.size() > delay_ ? &seen_[seen_.size() - 1 - delay_] : nullptr;
}

Sight Eyes::foresee(double ahead) const {
  const std::size_t end = seen_.size() - delay_;
  const std::size_t count = std::min(end, kept_);
  Sight then = seen_[end - 1].sight;
  for (Place Sight::*thing : {&Sight::trunk, &Sight::hand, &Sight::shoulder}) {
    // The line that fits best.
    const double middle = 0.5 * static_cast<double>(count - 1);
    Place mean = Place::Zero();
    Place slope = Place::Zero();
    double norm = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const Place& place = seen_[end - count + i].sight.*thing;
      const double off = static_cast<double>(i) - middle;
      mean += place / static_cast<double>(count);
      slope += off * place;
      norm += off * off;
    }
    then.*thing = mean;
    if (norm > 0.0) then.*thing += (middle + ahead / period_) / norm * slope;
  }
  return then;
}

void Mean::see(double t, const Place& place) {
  if (weight_ == 0.0) {
    mean_ = place;
    weight_ = 1.0;
  } else {
    // What is new in it: the error before has faded by `kept`.
    const double kept = std::exp(-(t - t_) / parameters_.correlation_time);
    if (kept < 1.0) {
      const double more = (1.0 - kept) / (1.0 + kept);
      weight_ += more;
      mean_ += more / weight_ * ((place - kept * last_) / (1.0 - kept) - mean_);
    }
  }
  last_ = place;
  t_ = t;
}

void Mean::moved(const Vec3& by, double doubt) {
  mean_.head<3>() += by;
  last_.head<3>() += by;
  const double share = doubt / parameters_.error;
  weight_ /= 1.0 + share * share * weight_;
}

}  // namespace baton
