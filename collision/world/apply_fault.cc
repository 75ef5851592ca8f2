#include "collision/world/apply_fault.h"

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "absl/types/optional.h"
#include "collision/geometry/validation.h"
#include "collision/world/world_snapshot.h"

namespace cwm::collision {
namespace {

// The keys of the payloads for FieldRule and ApplyFault. Debian's absl takes std::string, not
// std::string_view.
constexpr char kFieldUrl[] = "cwm.collision.FieldRule";
constexpr char kFaultUrl[] = "cwm.collision.ApplyFault";

}  // namespace

absl::Status InvalidFieldError(std::string_view field, std::string_view rule) {
  const std::string name(field), broken(rule);
  absl::Status status = absl::InvalidArgumentError(absl::StrCat(name, " ", broken));
  status.SetPayload(kFieldUrl, absl::Cord(absl::StrCat(name, "\n", broken)));
  return status;
}

absl::Status WithField(std::string_view field, absl::Status status) {
  const std::string rule(status.message());
  status.SetPayload(kFieldUrl, absl::Cord(absl::StrCat(std::string(field), "\n", rule)));
  return status;
}

std::optional<FieldRule> FieldRuleOf(const absl::Status& status) {
  const absl::optional<absl::Cord> payload = status.GetPayload(kFieldUrl);
  if (!payload.has_value()) return std::nullopt;
  const std::string text(*payload);
  const std::size_t rule = text.find('\n') + 1;
  return FieldRule{.field = text.substr(0, rule - 1), .rule = text.substr(rule)};
}

absl::Status WithChangeIndex(std::size_t index, const absl::Status& status) {
  absl::Status placed(status.code(), absl::StrCat("changes[", index, "]: ", status.message()));
  const FieldRule fault =
      FieldRuleOf(status).value_or(FieldRule{"", std::string(status.message())});
  // One line each for index, field and rule.
  placed.SetPayload(kFaultUrl,
                    absl::Cord(absl::StrCat(index, "\n", fault.field, "\n", fault.rule)));
  return placed;
}

absl::Status RobotNotFoundError(const std::string& name) {
  return absl::NotFoundError(absl::StrCat("robot '", name, "' does not exist"));
}

absl::Status InvalidNameError(std::string_view name) {
  return InvalidFieldError("name", absl::StrCat("'", std::string(name),
                                                "' must be 1 to 128 letters, digits or \"_-./\""));
}

absl::Status InvalidPoseError(std::string_view field) {
  return InvalidFieldError(
      field, absl::StrCat("must be a finite rigid transform within ", kMaxCoordinate_m, " m"));
}

std::optional<ApplyFault> FaultOf(const absl::Status& status) {
  const absl::optional<absl::Cord> payload = status.GetPayload(kFaultUrl);
  if (!payload.has_value()) return std::nullopt;
  const std::string text(*payload);
  const std::size_t field = text.find('\n') + 1, rule = text.find('\n', field) + 1;
  return ApplyFault{.change = std::stoul(text),
                    .field = text.substr(field, rule - field - 1),
                    .rule = text.substr(rule)};
}

}  // namespace cwm::collision
