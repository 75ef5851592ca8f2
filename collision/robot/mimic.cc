#include "collision/robot/mimic.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "absl/strings/str_cat.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

bool HasOneVariable(JointKind kind) { return VariableCount(kind) == 1; }

class Resolver {
 public:
  explicit Resolver(const RobotDescription& robot) : robot_(robot) {
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      index_.emplace(robot.joints[i].name, static_cast<int>(i));
    }
  }

  absl::StatusOr<std::vector<std::optional<ResolvedMimic>>> Resolve() const {
    std::vector<std::optional<ResolvedMimic>> resolved_mimics;
    for (const Joint& joint : robot_.joints) {
      absl::StatusOr<std::optional<ResolvedMimic>> resolved = Resolve(joint);
      if (!resolved.ok()) return resolved.status();
      resolved_mimics.push_back(*resolved);
    }
    return resolved_mimics;
  }

 private:
  absl::StatusOr<std::optional<ResolvedMimic>> Resolve(const Joint& joint) const {
    if (!joint.mimic.has_value()) return std::optional<ResolvedMimic>();
    if (!HasOneVariable(joint.kind)) {
      return Fault(joint, "must not be given for a joint without exactly one variable");
    }
    if (absl::Status status = CheckSize(joint); !status.ok()) return status;
    ResolvedMimic resolved;
    const Joint* at = &joint;
    for (std::size_t steps = 0; at->mimic.has_value(); ++steps) {
      if (steps > robot_.joints.size()) return Fault(joint, "must not lead back to itself");
      const auto source = index_.find(at->mimic->joint);
      if (source == index_.end()) return Fault(*at, "must be a joint of the robot");
      resolved.source = source->second;
      resolved.offset += resolved.multiplier * at->mimic->offset;
      resolved.multiplier *= at->mimic->multiplier;
      at = &robot_.joints[source->second];
      if (!HasOneVariable(at->kind)) {
        return Fault(joint, absl::StrCat("leads to the ", std::string(NameOf(at->kind)), " joint ",
                                         Quoted(at->name), ", must be one with one variable"));
      }
    }
    if (!IsInRange(resolved.multiplier) || !IsInRange(resolved.offset)) {
      return Fault(joint, absl::StrCat("leads to ", Quoted(at->name), " by a multiplier of ",
                                       resolved.multiplier, " and an offset of ", resolved.offset,
                                       " along the chain, must be at most ", kMaxMimicCoefficient,
                                       " in magnitude, both"));
    }
    return std::optional<ResolvedMimic>(resolved);
  }

  static bool IsInRange(double value) {
    return std::abs(value) <= kMaxMimicCoefficient;
  }  // not NaN

  static absl::Status CheckSize(const Joint& joint) {
    const auto fault = [&](const char* attribute, double value) {
      return FaultAt(
          absl::StrCat("urdf: joint ", Quoted(joint.name), ": mimic ", attribute, " is ", value),
          absl::StrCat("must be at most ", kMaxMimicCoefficient, " in magnitude"));
    };
    if (!IsInRange(joint.mimic->multiplier)) return fault("multiplier", joint.mimic->multiplier);
    if (!IsInRange(joint.mimic->offset)) return fault("offset", joint.mimic->offset);
    return absl::OkStatus();
  }

  static absl::Status Fault(const Joint& joint, const std::string& rule) {
    return FaultAt(absl::StrCat("urdf: joint ", Quoted(joint.name), ": mimic joint is ",
                                Quoted(joint.mimic->joint)),
                   rule);
  }

  const RobotDescription& robot_;
  std::map<std::string, int> index_;
};

}  // namespace

absl::StatusOr<std::vector<std::optional<ResolvedMimic>>> ResolveMimics(
    const RobotDescription& robot) {
  return Resolver(robot).Resolve();
}

std::optional<VariableRange> NarrowRange(const VariableRange& source, const ResolvedMimic& resolved,
                                         const JointLimits& own) {
  if (!own.lower.has_value() || !own.upper.has_value()) return source;
  const double lower = *own.lower - kMimicTolerance - resolved.offset;
  const double upper = *own.upper + kMimicTolerance - resolved.offset;
  if (resolved.multiplier == 0) {
    return lower <= 0 && upper >= 0 ? std::optional(source) : std::nullopt;
  }
  const double at_lower = lower / resolved.multiplier, at_upper = upper / resolved.multiplier;
  const VariableRange both = {.lower = std::max(source.lower, std::min(at_lower, at_upper)),
                              .upper = std::min(source.upper, std::max(at_lower, at_upper))};
  const bool is_whole = both.lower == source.lower && both.upper == source.upper;
  const double play = 2.01 * kMimicTolerance / std::abs(resolved.multiplier);  // plus rounding
  return is_whole || both.upper - both.lower > play ? std::optional(both) : std::nullopt;
}

}  // namespace cwm::collision
