#include "clients/cli/question_arguments.h"

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

void AddQuestionOptions(CLI::App& command, QuestionArguments& question) {
  command.add_option("--engine", question.engine, "auto (default), exact, fcl or bullet")
      ->transform(OneOf(ShortNames<pb::Engine>()))
      ->type_name("ENGINE");
  command
      .add_option("--representation", question.representation,
                  "of the objects: hybrid (default), shapes or surfaces")
      ->transform(OneOf(ShortNames<pb::Representation>()))
      ->type_name("REP");
  command
      .add_option("--unseen", question.unseen,
                  "what space that no sensor has seen counts as: block (default), report or ignore")
      ->transform(OneOf(ShortNames<pb::UnseenSpace>()))
      ->type_name("SPACE");
  command.add_option("--max-distance", question.max_distance_m, "leave out what is farther (m)")
      ->type_name("M");
  command
      .add_option("--ignore", question.ignore, "leave this object or robot out; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME");
  command
      .add_option("--what-if", question.what_if,
                  absl::StrCat("answer as if the world were changed so, for this question alone: ",
                               kChangeForms, "; may be repeated, applied in order"))
      ->allow_extra_args(false)
      ->type_name("CHANGE");
  command.add_option("--time-budget", question.time_budget_s, "answer what is done by then (s)")
      ->check(PositiveSeconds)
      ->type_name("S");
  AddRevisionOption(command, question.at_revision);
}

void AddMarginOption(CLI::App& command, QuestionArguments& question) {
  command.add_option("--margin", question.margin_m, "collision means nearer than this (m)")
      ->type_name("M");
}

void AddPairRuleOptions(CLI::App& command, QuestionArguments& question) {
  command
      .add_option("--ignore-pair", question.ignore_pairs,
                  "let the two collide: NAME, ROBOT:LINK or '*' each; may be repeated")
      ->allow_extra_args(false)
      ->type_name("A,B");
  command
      .add_option("--margin-sigma", question.margin_sigma,
                  "widen fitted parts by so many deviations of their surfaces")
      ->type_name("K");
  command
      .add_option("--support-tolerance", question.support_tolerance_m,
                  "how deep an object that is attached or asks may reach into what supports it "
                  "(m, default 0.005)")
      ->type_name("M");
}

void AddVerdictOptions(CLI::App& command, VerdictArguments& arguments) {
  AddBodyOptions(command, arguments.body);
  AddQuestionOptions(command, arguments.question);
  AddMarginOption(command, arguments.question);
  AddPairRuleOptions(command, arguments.question);
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

absl::StatusOr<pb::QueryOptions> ToOptions(const QuestionArguments& question) {
  const auto revision = ParseRevision(question.at_revision);
  if (!revision.ok()) return revision.status();
  pb::QueryOptions options;
  *options.mutable_at_revision() = *revision;
  options.set_engine(question.engine);
  options.set_representation(question.representation);
  options.set_unseen(question.unseen);
  options.set_margin_m(question.margin_m);
  if (question.max_distance_m) options.set_max_distance_m(*question.max_distance_m);
  options.set_max_results(question.max_results);
  options.set_max_contacts(question.max_contacts);
  for (const std::string& name : question.ignore) options.add_ignore(name);
  for (const std::string& text : question.ignore_pairs) {
    const auto pair = ParsePair(text, "--ignore-pair");
    if (!pair.ok()) return pair.status();
    *options.add_ignore_pairs() = *pair;
  }
  for (const std::string& text : question.what_if) {
    const auto change = ParseChange(text, "--what-if");
    if (!change.ok()) return change.status();
    *options.add_overlay() = *change;
  }
  options.set_margin_sigma(question.margin_sigma);
  if (question.support_tolerance_m) {
    options.set_support_tolerance_m(*question.support_tolerance_m);
  }
  if (question.time_budget_s) *options.mutable_time_budget() = ToDuration(*question.time_budget_s);
  options.set_result_form(pb::RESULT_FORM_ROWS);
  options.set_scalar(pb::SCALAR_F64);
  return options;
}

std::string Footer(std::int64_t revision, std::int64_t completed, std::size_t asked,
                   const std::string& of_what) {
  return absl::StrCat("revision ", revision, ", ", completed, " of ", asked, " ", of_what,
                      asked == 1 ? "" : "s");
}

std::size_t RowCount(const std::vector<Batch>& batches) {
  std::size_t rows = 0;
  for (const Batch& batch : batches) rows += batch.row_count;
  return rows;
}

}  // namespace cwm::cli
