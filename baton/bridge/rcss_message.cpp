#include "baton/bridge/rcss_message.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "baton/model/error.hpp"

namespace baton::bridge {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kTwoDigits = 0.01;     ///< [°], [°/s], [m/s²]
constexpr double kThreeDigits = 0.001;  ///< of the torso's position and quaternion
constexpr std::size_t kLength = 4;      ///< bytes of a message's length

/// A joint of the models, the simulator's name of its limb, and its number there.
struct Row {
  std::string_view joint;
  std::string_view limb;
  int number;
};
/// The shoulders' pitch has one name in T1 and another in K1; K1 has no waist.
constexpr std::array<Row, 25> kJoints{{{"AAHead_yaw", "h", 1},
                                       {"Head_pitch", "h", 2},
                                       {"Left_Shoulder_Pitch", "la", 1},
                                       {"ALeft_Shoulder_Pitch", "la", 1},
                                       {"Left_Shoulder_Roll", "la", 2},
                                       {"Left_Elbow_Pitch", "la", 3},
                                       {"Left_Elbow_Yaw", "la", 4},
                                       {"Right_Shoulder_Pitch", "ra", 1},
                                       {"ARight_Shoulder_Pitch", "ra", 1},
                                       {"Right_Shoulder_Roll", "ra", 2},
                                       {"Right_Elbow_Pitch", "ra", 3},
                                       {"Right_Elbow_Yaw", "ra", 4},
                                       {"Waist", "t", 1},
                                       {"Left_Hip_Pitch", "ll", 1},
                                       {"Left_Hip_Roll", "ll", 2},
                                       {"Left_Hip_Yaw", "ll", 3},
                                       {"Left_Knee_Pitch", "ll", 4},
                                       {"Left_Ankle_Pitch", "ll", 5},
                                       {"Left_Ankle_Roll", "ll", 6},
                                       {"Right_Hip_Pitch", "rl", 1},
                                       {"Right_Hip_Roll", "rl", 2},
                                       {"Right_Hip_Yaw", "rl", 3},
                                       {"Right_Knee_Pitch", "rl", 4},
                                       {"Right_Ankle_Pitch", "rl", 5},
                                       {"Right_Ankle_Roll", "rl", 6}}};

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

RcssJoint rcss_joint(std::string_view model_joint) {
  const auto* row = std::find_if(kJoints.begin(), kJoints.end(), [&](const Row& r) { return r.joint == model_joint; });
  if (row == kJoints.end())
    throw InputError(fmt::format("joint '{}': the simulator's robots T1 and K1 have none of that name", model_joint));
  return {fmt::format("q_{}j{}", row->limb, row->number), fmt::format("{}e{}", row->limb, row->number)};
}

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
