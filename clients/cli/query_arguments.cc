#include "clients/cli/query_arguments.h"

#include <CLI/CLI.hpp>
#include <cmath>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/one_of.h"
#include "clients/cli/pair_arguments.h"
#include "clients/cli/what_if.h"

namespace cwm::cli {
namespace pb = cwm::v1;

google::protobuf::Duration ToDuration(double seconds) {
  google::protobuf::Duration duration;
  duration.set_seconds(static_cast<std::int64_t>(std::floor(seconds)));
  duration.set_nanos(static_cast<std::int32_t>((seconds - std::floor(seconds)) * 1e9));
  return duration;
}

void AddRevisionOption(CLI::App& command, std::string& at_revision) {
  command.add_option("--at-revision", at_revision, "latest (default), N (exactly), N+ (at least)")
      ->type_name("REV");
}

void AddQueryOptions(CLI::App& command, QueryArguments& query) {
  command.add_option("--engine", query.engine, "auto (default), exact, fcl or bullet")
      ->transform(OneOf(ShortNames<pb::Engine>()))
      ->type_name("ENGINE");
  command
      .add_option("--representation", query.representation,
                  "of the objects: hybrid (default), shapes or surfaces")
      ->transform(OneOf(ShortNames<pb::Representation>()))
      ->type_name("REP");
  command
      .add_option("--unseen", query.unseen,
                  "what space that no sensor has seen counts as: block (default), report or ignore")
      ->transform(OneOf(ShortNames<pb::UnseenSpace>()))
      ->type_name("SPACE");
  command.add_option("--max-distance", query.max_distance_m, "leave out what is farther (m)")
      ->type_name("M");
  command.add_option("--ignore", query.ignore, "leave this object or robot out; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME");
  command
      .add_option("--only", query.only,
                  "test nothing but this object, robot or link (ROBOT:LINK); may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME");
  command
      .add_option("--what-if", query.what_if,
                  absl::StrCat("answer as if the world were changed so, for this question alone: ",
                               kChangeForms, "; may be repeated, applied in order"))
      ->allow_extra_args(false)
      ->type_name("CHANGE");
  command.add_option("--time-budget", query.time_budget_s, "answer what is done by then (s)")
      ->check(PositiveSeconds)
      ->type_name("S");
  AddRevisionOption(command, query.at_revision);
}

void AddMarginOption(CLI::App& command, QueryArguments& query) {
  command.add_option("--margin", query.margin_m, "collision means nearer than this (m)")
      ->type_name("M");
}

void AddPairRuleOptions(CLI::App& command, QueryArguments& query) {
  command
      .add_option("--ignore-pair", query.ignore_pairs,
                  "let the two collide: NAME, ROBOT:LINK or '*' each; may be repeated")
      ->allow_extra_args(false)
      ->type_name("A,B");
  command
      .add_option("--margin-sigma", query.margin_sigma,
                  "widen fitted parts by so many deviations of their surfaces")
      ->type_name("K");
  command
      .add_option("--support-tolerance", query.support_tolerance_m,
                  "how deep an object that is attached or asks may reach into what supports it "
                  "(m, default 0.005)")
      ->type_name("M");
}

void AddVerdictOptions(CLI::App& command, VerdictArguments& arguments) {
  AddBodyOptions(command, arguments.body);
  AddQueryOptions(command, arguments.query);
  AddMarginOption(command, arguments.query);
  AddPairRuleOptions(command, arguments.query);
  command.add_flag("--exit-code", arguments.exit_code,
                   "end with 0 when all that is asked is free, with 10 when any of it collides, "
                   "else with 11: out of limits, grazing, undecided or not computed");
}

absl::StatusOr<pb::AtRevision> ParseRevision(const std::string& text) {
  pb::AtRevision revision;
  if (text.empty() || text == "latest") {
    revision.set_latest(true);
    return revision;
  }
  const bool at_least = text.back() == '+';
  std::int64_t number = 0;
  if (!absl::SimpleAtoi(text.substr(0, text.size() - (at_least ? 1 : 0)), &number) || number < 0) {
    return UsageError(
        absl::StrCat("--at-revision: \"", text, "\" must be latest, N (exactly) or N+ (at least)"));
  }
  if (at_least) {
    revision.set_at_least(number);
  } else {
    revision.set_exact(number);
  }
  return revision;
}

absl::StatusOr<pb::QueryOptions> ParseQueryOptions(const QueryArguments& query) {
  const auto revision = ParseRevision(query.at_revision);
  if (!revision.ok()) return revision.status();
  pb::QueryOptions options;
  *options.mutable_at_revision() = *revision;
  options.set_engine(query.engine);
  options.set_representation(query.representation);
  options.set_unseen(query.unseen);
  options.set_margin_m(query.margin_m);
  if (query.max_distance_m) options.set_max_distance_m(*query.max_distance_m);
  options.set_max_results(query.max_results);
  options.set_max_contacts(query.max_contacts);
  for (const std::string& name : query.ignore) options.add_ignore(name);
  for (const std::string& text : query.only) {
    const auto named = ParsePairMember(text, "--only");
    if (!named.ok()) return named.status();
    *options.add_only() = *named;
  }
  for (const std::string& text : query.ignore_pairs) {
    const auto pair = ParsePair(text, "--ignore-pair");
    if (!pair.ok()) return pair.status();
    *options.add_ignore_pairs() = *pair;
  }
  for (const std::string& text : query.what_if) {
    const auto change = ParseChange(text, "--what-if");
    if (!change.ok()) return change.status();
    *options.add_overlay() = *change;
  }
  options.set_margin_sigma(query.margin_sigma);
  if (query.support_tolerance_m) {
    options.set_support_tolerance_m(*query.support_tolerance_m);
  }
  if (query.time_budget_s) *options.mutable_time_budget() = ToDuration(*query.time_budget_s);
  options.set_result_form(pb::RESULT_FORM_ROWS);
  options.set_scalar(pb::SCALAR_F64);
  return options;
}

std::string Footer(std::int64_t revision, std::int64_t completed, std::size_t row_count,
                   const std::string& unit) {
  return absl::StrCat("revision ", revision, ", ", completed, " of ", row_count, " ", unit,
                      row_count == 1 ? "" : "s");
}

std::size_t RowCount(const std::vector<Batch>& batches) {
  std::size_t rows = 0;
  for (const Batch& batch : batches) rows += batch.row_count;
  return rows;
}

}  // namespace cwm::cli
