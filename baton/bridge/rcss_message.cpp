#include "baton/bridge/rcss_message.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace baton::bridge {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kTwoDigits = 0.01;     ///< [°], [°/s], [m/s²]
constexpr double kThreeDigits = 0.001;  ///< of the torso's position and quaternion
constexpr std::size_t kLength = 4;      ///< bytes of a message's length

double uncut_angle(const SExpr& degrees) {
  return kDegree * uncut(degrees.number(), kTwoDigits);
}

/// The three numbers after a list's head, each not cut off any more.
Vec3 uncut_vector(const SExpr& list, double digit) {
  return {uncut(list.at(1).number(), digit), uncut(list.at(2).number(), digit), uncut(list.at(3).number(), digit)};
}

Pose torso_in(const SExpr& all) {
  const SExpr& q = all.find("quat").find("q");
  std::array<double, 4> wxyz{};
  for (std::size_t i = 0; i < wxyz.size(); ++i)
    wxyz[i] = uncut(q.at(i + 1).number(), kThreeDigits);
  const Eigen::Quaterniond turned(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!(std::abs(turned.norm() - 1.0) < 0.01))
    throw SExprError(fmt::format("a quaternion of norm {:.3g}: must be 1", turned.norm()));
  Pose torso;
  torso.p = uncut_vector(all.find("pos").find("p"), kThreeDigits);
  torso.R = turned.normalized().toRotationMatrix();
  return torso;
}

}  // namespace

double uncut(double value, double digit) {
  return value == 0.0 ? 0.0 : value + std::copysign(0.5 * digit, value);
}

Perception perception_in(std::string_view text, const std::vector<RcssJoint>& joints) {
  const SExpr all{{}, parse_sexprs(text)};
  Perception p;
  // A time whose last bits are too low is cut off to 0.01 s too little.
  p.cycle = std::lround(std::ceil(all.find("time").find("now").at(1).number() / kRcssCycle - 0.25));
  p.play_mode = all.find("GS").find("pm").at(1).atom;
  p.rate = kDegree * uncut_vector(all.find("GYR").find("rt"), kTwoDigits);
  p.acceleration = uncut_vector(all.find("ACC").find("a"), kTwoDigits);
  p.torso = torso_in(all);
  const auto size = static_cast<Eigen::Index>(joints.size());
  p.q = VecX::Constant(size, std::numeric_limits<double>::quiet_NaN());
  p.dq = VecX::Zero(size);
  for (const SExpr& element : all.list) {
    if (!element.is("HJ")) continue;
    const std::string_view name = element.find("n").at(1).atom;
    const auto joint =
        std::find_if(joints.begin(), joints.end(), [&](const RcssJoint& j) { return j.perceptor == name; });
    if (joint == joints.end()) throw SExprError(fmt::format("a joint '{}', which the robot does not have", name));
    const auto i = joint - joints.begin();
    p.q[i] = uncut_angle(element.find("ax").at(1));
    p.dq[i] = uncut_angle(element.find("vx").at(1));
  }
  for (Eigen::Index i = 0; i < size; ++i) {
    if (std::isnan(p.q[i]))
      throw SExprError(fmt::format("no joint '{}'", joints[static_cast<std::size_t>(i)].perceptor));
  }
  return p;
}

std::string init_text(std::string_view robot, std::string_view team, int player) {
  return fmt::format("(init {} {} {})", robot, team, player);
}

std::string beam_text(const Vec3& place) {
  return fmt::format("(beam {} {} {})", place.x(), place.y(), place.z() / kDegree);
}

std::string servo_text(const RcssJoint& joint, const RcssServo& servo) {
  return fmt::format("({} {} {} {} {} {})", joint.effector, servo.q / kDegree, servo.dq / kDegree, servo.kp, servo.kd,
                     servo.tau);
}

std::string rcss_framed(std::string_view text) {
  std::string bytes;
  for (std::size_t i = 0; i < kLength; ++i)
    bytes += static_cast<char>(text.size() >> (8 * (kLength - 1 - i)) & 0xffU);
  return bytes.append(text);
}

std::optional<std::string> take_rcss_message(std::string& bytes) {
  if (bytes.size() < kLength) return std::nullopt;
  std::size_t length = 0;
  for (std::size_t i = 0; i < kLength; ++i)
    length = length << 8U | static_cast<unsigned char>(bytes[i]);
  if (length == 0 || length > kLongestPerception)
    throw SExprError(fmt::format("a message of {} bytes: must be 1 to {}", length, kLongestPerception));
  if (bytes.size() < kLength + length) return std::nullopt;
  std::string text = bytes.substr(kLength, length);
  bytes.erase(0, kLength + length);
  return text;
}

}  // namespace baton::bridge
