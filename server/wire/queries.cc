#include "server/wire/queries.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/pair_options.h"
#include "server/wire/pair_rules.h"
#include "server/wire/poses.h"
#include "server/wire/shapes.h"
#include "server/wire/times.h"

namespace cwm::server {
namespace {

constexpr int kMaxResults = 64;
constexpr int kMaxIgnored = 65'536;
constexpr double kMaxSupportTolerance_m = 0.1;
constexpr double kMaxSigmas = 1'000;  // far beyond any confidence, without overflow

template <class Enum>
absl::Status UnknownValue(Enum value, std::string_view type, const FieldPath& path) {
  return path.Error(
      absl::StrCat("is ", static_cast<int>(value), ", must be a known ", std::string(type)));
}

absl::StatusOr<collision::EngineChoice> EngineFromProto(v1::Engine engine, const FieldPath& path) {
  switch (engine) {
    case v1::ENGINE_UNSPECIFIED:
    case v1::ENGINE_AUTO:
      return collision::EngineChoice::kAuto;
    case v1::ENGINE_EXACT:
      return collision::EngineChoice::kExact;
    case v1::ENGINE_FCL:
      return collision::EngineChoice::kFcl;
    case v1::ENGINE_BULLET:
      return collision::EngineChoice::kBullet;
    default:
      return UnknownValue(engine, "Engine", path);
  }
}

absl::StatusOr<collision::UnseenSpace> UnseenSpaceFromProto(v1::UnseenSpace unseen,
                                                            const FieldPath& path) {
  switch (unseen) {
    case v1::UNSEEN_SPACE_UNSPECIFIED:
    case v1::UNSEEN_SPACE_BLOCK:
      return collision::UnseenSpace::kBlock;
    case v1::UNSEEN_SPACE_IGNORE:
      return collision::UnseenSpace::kIgnore;
    case v1::UNSEEN_SPACE_REPORT:
      return collision::UnseenSpace::kReport;
    default:
      return UnknownValue(unseen, "UnseenSpace", path);
  }
}

absl::StatusOr<collision::Representation> RepresentationFromProto(v1::Representation representation,
                                                                  const FieldPath& path) {
  switch (representation) {
    case v1::REPRESENTATION_UNSPECIFIED:
    case v1::REPRESENTATION_HYBRID:
      return collision::Representation::kHybrid;
    case v1::REPRESENTATION_SHAPES:
      return collision::Representation::kShapes;
    case v1::REPRESENTATION_SURFACES:
      return collision::Representation::kSurfaces;
    default:
      return UnknownValue(representation, "Representation", path);
  }
}

// Checks a count; 0 means the default `otherwise`.
absl::StatusOr<int> CountOf(int given, int otherwise, int max, const FieldPath& path) {
  if (auto status = CheckRange(given, {0, max}, path); !status.ok()) return status;
  return given == 0 ? otherwise : given;
}

absl::Status SetForm(const v1::QueryOptions& options, const FieldPath& path,
                     ParsedQueryOptions& result) {
  if (!v1::ResultForm_IsValid(options.result_form())) {
    return UnknownValue(options.result_form(), "ResultForm", path.Field("result_form"));
  }
  if (!v1::Scalar_IsValid(options.scalar())) {
    return UnknownValue(options.scalar(), "Scalar", path.Field("scalar"));
  }
  result.form = options.result_form() == v1::RESULT_FORM_ROWS ? Form::kRows : Form::kColumns;
  result.precision = options.scalar() == v1::SCALAR_F32 ? Precision::kSingle : Precision::kDouble;
  return absl::OkStatus();
}

absl::Status SetQuery(const v1::QueryOptions& options, const ContactCount& count,
                      const FieldPath& path, collision::QueryOptions& query) {
  auto engine = EngineFromProto(options.engine(), path.Field("engine"));
  if (!engine.ok()) return engine.status();
  query.engine = *engine;
  auto representation =
      RepresentationFromProto(options.representation(), path.Field("representation"));
  if (!representation.ok()) return representation.status();
  query.representation = *representation;
  auto status = CheckLength(options.margin_m(), path.Field("margin_m"));
  if (!status.ok()) return status;
  query.margin_m = options.margin_m();
  if (options.has_max_distance_m()) {
    status = CheckLength(options.max_distance_m(), path.Field("max_distance_m"));
    if (!status.ok()) return status;
    query.max_distance_m = options.max_distance_m();
  }
  auto results = CountOf(options.max_results(), 1, kMaxResults, path.Field("max_results"));
  if (!results.ok()) return results.status();
  query.max_results = *results;
  auto contacts =
      CountOf(options.max_contacts(), count.otherwise, count.max, path.Field("max_contacts"));
  if (!contacts.ok()) return contacts.status();
  query.max_contacts = *contacts;
  status = CheckRange(options.ignore_size(), {0, kMaxIgnored}, path.Field("ignore"));
  if (!status.ok()) return status;
  query.ignore.assign(options.ignore().begin(), options.ignore().end());
  return absl::OkStatus();
}

// Sets the query's options about pairs.
absl::Status SetPairs(const v1::QueryOptions& options, const FieldPath& path,
                      collision::QueryOptions& query) {
  constexpr auto kMaxPairs = static_cast<std::int64_t>(collision::kMaxPairRules);
  auto status = CheckRange(options.ignore_pairs_size(), {0, kMaxPairs}, path.Field("ignore_pairs"));
  if (!status.ok()) return status;
  for (int i = 0; i < options.ignore_pairs_size(); ++i) {
    auto pair = NamedPairFromProto(options.ignore_pairs(i), path.Item("ignore_pairs", i));
    if (!pair.ok()) return pair.status();
    query.ignore_pairs.push_back(*std::move(pair));
  }
  auto only = NamedThingsFromProto(options.only(), path);
  if (!only.ok()) return only.status();
  query.only = *std::move(only);
  auto unseen = UnseenSpaceFromProto(options.unseen(), path.Field("unseen"));
  if (!unseen.ok()) return unseen.status();
  query.unseen = *unseen;
  if (options.has_support_tolerance_m()) {
    query.support_tolerance_m = options.support_tolerance_m();
    if (!(query.support_tolerance_m >= 0 && query.support_tolerance_m <= kMaxSupportTolerance_m)) {
      return path.Field("support_tolerance_m")
          .Error(absl::StrCat("is ", query.support_tolerance_m, ", must be 0 to ",
                              kMaxSupportTolerance_m));
    }
  }
  if (options.verdicts_only()) query.naming = collision::Naming::kWhereTested;
  query.margin_sigma = options.margin_sigma();
  if (query.margin_sigma >= 0 && query.margin_sigma <= kMaxSigmas) return absl::OkStatus();
  return path.Field("margin_sigma")
      .Error(absl::StrCat("is ", query.margin_sigma, ", must be finite, not negative and at most ",
                          kMaxSigmas));
}

absl::StatusOr<StateQuery> ShapesQuery(const v1::Subject::Shapes& shapes, const QuerySource& source,
                                       const FieldPath& path) {
  auto status = CheckRange(shapes.shapes_size(), {1, kMaxBodyShapes}, path.Field("shapes"));
  if (!status.ok()) return status;
  std::vector<Placed<>> parts;
  parts.reserve(shapes.shapes_size());
  for (int i = 0; i < shapes.shapes_size(); ++i) {
    auto part =
        PlacedShapeFromProto(shapes.shapes(i), source.store, path.Item("shapes", i), source.budget);
    if (!part.ok()) return part.status();
    parts.push_back(*std::move(part));
  }
  auto rows = PosesFromProto(shapes.x_world_body(), source.limits.max_batch_rows,
                             path.Field("x_world_body"));
  if (!rows.ok()) return rows.status();
  collision::QueryBody body = collision::BodyFromShapes(std::move(parts), source.budget);
  if (body.geometry == nullptr) return source.budget->status();
  return StateQuery{std::move(body), *std::move(rows)};
}

absl::StatusOr<StateQuery> ObjectQuery(const v1::Subject::WorldObject& subject,
                                       const QuerySource& source, const FieldPath& path) {
  if (auto status = CheckName(subject.name(), path.Field("name")); !status.ok()) return status;
  const collision::WorldObjectPtr object = source.snapshot.Find(subject.name());
  if (object == nullptr) return UnknownObject(subject.name());
  const bool names_itself = std::ranges::any_of(
      source.only, [&](const collision::NamedThing& thing) { return thing.name == object->name; });
  if (names_itself) {
    return path.Field("name").Error(absl::StrCat(
        "is \"", subject.name(),
        "\", which options.only must not name: an object is not tested against itself"));
  }
  if (subject.x_world_object().data().empty()) {
    return StateQuery{collision::BodyFromObject(*object), std::vector<Pose>{object->X_WO}};
  }
  auto rows = PosesFromProto(subject.x_world_object(), source.limits.max_batch_rows,
                             path.Field("x_world_object"));
  if (!rows.ok()) return rows.status();
  return StateQuery{collision::BodyFromObject(*object), *std::move(rows)};
}

absl::StatusOr<StateQuery> PointsQuery(const v1::Subject::Points& points, const QuerySource& source,
                                       const FieldPath& path) {
  auto rows = PointPosesFromProto(points, source.limits.max_batch_rows, path);
  if (!rows.ok()) return rows.status();
  return StateQuery{collision::BodyFromShapes({Placed<>{Pose::Identity(), Sphere{kPointRadius_m}}}),
                    *std::move(rows)};
}

}  // namespace

absl::StatusOr<RevisionRule> RevisionRuleFromProto(const v1::AtRevision& rule,
                                                   const FieldPath& path) {
  switch (rule.revision_case()) {
    case v1::AtRevision::kLatest:
    case v1::AtRevision::REVISION_NOT_SET:
      return Latest{};
    case v1::AtRevision::kAtLeast:
      if (rule.at_least() < 0) return path.Field("at_least").Error("is negative, must not be");
      return AtLeast{{rule.at_least()}};
    case v1::AtRevision::kExact:
      if (rule.exact() < 0) return path.Field("exact").Error("is negative, must not be");
      return Exactly{{rule.exact()}};
  }
  return Latest{};
}

absl::StatusOr<ParsedQueryOptions> QueryOptionsFromProto(const v1::QueryOptions& options,
                                                         const FieldPath& path,
                                                         const ContactCount& contacts) {
  ParsedQueryOptions result;
  auto rule = RevisionRuleFromProto(options.at_revision(), path.Field("at_revision"));
  if (!rule.ok()) return rule.status();
  result.at_revision = *rule;
  result.world_uid = options.world_uid();
  if (auto status = SetQuery(options, contacts, path, result.query); !status.ok()) return status;
  if (auto status = SetPairs(options, path, result.query); !status.ok()) return status;
  if (auto status = SetForm(options, path, result); !status.ok()) return status;
  if (options.has_time_budget()) {
    auto budget = DurationFromProto(options.time_budget(), path.Field("time_budget"));
    if (!budget.ok()) return budget.status();
    result.time_budget = *budget;
  }
  return result;
}

absl::StatusOr<StateQuery> StateQueryFromProto(const v1::Subject& subject,
                                               const QuerySource& source, const FieldPath& path) {
  switch (subject.what_case()) {
    case v1::Subject::kShapes:
      return ShapesQuery(subject.shapes(), source, path.Field("shapes"));
    case v1::Subject::kObject:
      return ObjectQuery(subject.object(), source, path.Field("object"));
    case v1::Subject::kPoints:
      return PointsQuery(subject.points(), source, path.Field("points"));
    case v1::Subject::kRobot:
      return RobotQueryFromProto(subject.robot(), source, path.Field("robot"));
    case v1::Subject::WHAT_NOT_SET:
      break;
  }
  return path.Field("what").Error("is absent, must be one of shapes, object, points, robot");
}

absl::Status CheckForm(Form form, std::size_t row_count, const Limits& limits) {
  if (form == Form::kColumns) return absl::OkStatus();
  if (static_cast<std::int64_t>(row_count) <= limits.max_rows_as_messages) return absl::OkStatus();
  return InvalidField(
      "options.result_form",
      absl::StrCat("is RESULT_FORM_ROWS for ", row_count,
                   " rows, must be RESULT_FORM_COLUMNS above ", limits.max_rows_as_messages));
}

std::int64_t MaxAnswers(Form form, const Limits& limits) {
  return form == Form::kRows ? limits.max_answers_as_messages : limits.max_answers;
}

absl::Status CheckAnswers(const AnswerBound& bound, Form form, const Limits& limits) {
  const std::int64_t max_answers = MaxAnswers(form, limits);
  const auto rows = std::max<std::int64_t>(1, static_cast<std::int64_t>(bound.row_count));
  if (bound.per_row <= max_answers / rows) return absl::OkStatus();
  const FieldPath root;
  return root.Field(bound.field)
      .Error(absl::StrCat("is ", bound.per_row, " for ", rows, " rows, must be at most ",
                          max_answers / rows, ": a batch has at most ", max_answers,
                          form == Form::kRows ? " answers as RESULT_FORM_ROWS" : " answers"));
}

absl::Status UnknownObject(const std::string& name) {
  return MakeError(absl::StatusCode::kNotFound, absl::StrCat("no object is named \"", name, "\""),
                   {.reason = "OBJECT_UNKNOWN",
                    .fields = {},
                    .metadata = {{"object", name}},
                    .retry_after_s = std::nullopt});
}

}  // namespace cwm::server
