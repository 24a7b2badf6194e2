/// The type of a motion that may be executed.
#pragma once

#include <memory>
#include <utility>

#include "baton/motion/motion.hpp"

namespace baton {

/// A motion that was verified whole. Only `Verifier` makes one, and nothing changes it afterwards: to change a motion
/// is to copy it and to verify the copy. Copies of the handle share the motion. One that was moved from may only be
/// assigned to or destroyed.
class VerifiedMotion {
 public:
  [[nodiscard]] const Motion& operator*() const { return proof_->motion; }
  [[nodiscard]] const Motion* operator->() const { return &proof_->motion; }
  [[nodiscard]] const Certificate& certificate() const { return proof_->certificate; }

 private:
  friend class Verifier;
  struct Proof {
    Motion motion;
    Certificate certificate;
  };
  VerifiedMotion(Motion motion, Certificate certificate)
      : proof_(std::make_shared<const Proof>(Proof{std::move(motion), std::move(certificate)})) {}

  std::shared_ptr<const Proof> proof_;
};

}  // namespace baton
