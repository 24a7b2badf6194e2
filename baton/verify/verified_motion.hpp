/// Verified motions, the only ones that are executed.
#pragma once

#include <memory>
#include <utility>

#include "baton/motion/motion.hpp"

namespace baton {

/// A motion that was verified at every tick. Only `Verifier` makes one, and it is immutable: a changed motion is a
/// copy, to be verified again. Copies of this handle share the motion. A moved-from handle may only be assigned or
/// destroyed.
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
