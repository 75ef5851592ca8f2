// cwm allow, cwm margin, cwm rules
#include <algorithm>
#include <memory>
#include <optional>
#include <ostream>
#include <string>

#include "absl/strings/str_cat.h"
#include "clients/cli/change_arguments.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/natural_order.h"
#include "clients/cli/pair_arguments.h"
#include "clients/cli/quantity.h"
#include "clients/cli/query_arguments.h"
#include "clients/cli/table.h"
#include "clients/cli/unknown_names.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

constexpr char kPairMemberForms[] =
    "A and B are NAME (of an object, or of a robot with all its links), ROBOT:LINK, or '*' for\n"
    "everything, bodies without a name included. They need not be there, yet or any more.";

constexpr double kMaxDuration_s = 366 * 24 * 3600;  // the server's limit

struct RuleArguments {
  std::string a, b;
  ChangeArguments change;
};

struct AllowArguments : RuleArguments {
  std::optional<double> for_s;
  bool withdraw = false, check = false;
};

struct MarginArguments : RuleArguments {
  std::optional<double> margin_m;
  bool unset = false;
};

absl::StatusOr<pb::NamedPair> PairOf(const RuleArguments& arguments) {
  const auto a = ParsePairMember(arguments.a, "A");
  if (!a.ok()) return a.status();
  const auto b = ParsePairMember(arguments.b, "B");
  if (!b.ok()) return b.status();
  pb::NamedPair pair;
  *pair.mutable_a() = *a;
  *pair.mutable_b() = *b;
  return pair;
}

std::string FormatRulePair(const RuleArguments& arguments) {
  return absl::StrCat(arguments.a, " and ", arguments.b);
}

absl::Status ApplyRule(Session& session, const RuleArguments& arguments, const pb::Change& change,
                       const pb::NamedPair& pair, const std::string& done) {
  absl::Status status = Apply(session, arguments.change, {change}, done);
  if (status.ok()) WarnAboutUnknownNames(session, pair);
  return status;
}

absl::Status Allow(Session& session, const AllowArguments& arguments) {
  const auto pair = PairOf(arguments);
  if (!pair.ok()) return pair.status();
  pb::Change change;
  *change.mutable_allow()->mutable_pair() = *pair;
  change.mutable_allow()->set_withdraw(arguments.withdraw);
  change.mutable_allow()->set_check(arguments.check);
  std::string done = absl::StrCat(FormatRulePair(arguments), arguments.withdraw ? ": withdrawn"
                                                             : arguments.check  ? ": checked"
                                                                                : ": may collide");
  if (arguments.for_s) {
    if (!(*arguments.for_s > 0 && *arguments.for_s <= kMaxDuration_s)) {  // false for NaN
      return UsageError(absl::StrCat("--for: is ", *arguments.for_s,
                                     ", must be positive and at most ", kMaxDuration_s, " s"));
    }
    *change.mutable_allow()->mutable_expires_after() = ToDuration(*arguments.for_s);
    absl::StrAppend(&done, " for ", *arguments.for_s, " s");
  }
  return ApplyRule(session, arguments, change, *pair, done);
}

absl::Status SetMargin(Session& session, const MarginArguments& arguments) {
  if (arguments.margin_m.has_value() == arguments.unset) {
    return UsageError("one of METRES and --unset");
  }
  const auto pair = PairOf(arguments);
  if (!pair.ok()) return pair.status();
  pb::Change change;
  *change.mutable_margin()->mutable_pair() = *pair;
  if (arguments.margin_m) change.mutable_margin()->set_margin_m(*arguments.margin_m);
  return ApplyRule(session, arguments, change, *pair,
                   absl::StrCat(FormatRulePair(arguments),
                                arguments.margin_m ? ": margin " + FormatLength(*arguments.margin_m)
                                                   : ": no margin of their own"));
}

void PrintRules(const pb::GetWorldResponse& world, TableStyle style, std::ostream& out) {
  std::vector<TableRow> rows;
  for (const pb::PairRule& rule : world.pair_rules()) {
    rows.push_back({.cells = {PairMemberText(rule.pair().a()), PairMemberText(rule.pair().b()),
                              FormatRule(rule)}});
  }
  std::stable_sort(rows.begin(), rows.end(), [](const TableRow& a, const TableRow& b) {
    return a.cells[0] == b.cells[0] ? NaturalLess(a.cells[1], b.cells[1])
                                    : NaturalLess(a.cells[0], b.cells[0]);
  });
  if (rows.empty()) {
    out << "no rules of pairs\n";
  } else {
    PrintTable({{"A"}, {"B"}, {"RULE"}}, rows, style, out);
  }
  out << "revision " << world.revision() << "\n";
}

absl::Status List(Session& session) {
  pb::GetWorldRequest request;
  request.set_world(session.world);
  const client::Connection& connection = session.connection();
  const auto world =
      connection.Call(&pb::WorldService::Stub::GetWorld, connection.worlds(), request);
  if (!world.ok()) return world.status();
  session.PrintList(
      *world,
      [&] {
        for (const pb::PairRule& rule : world->pair_rules()) session.PrintLine(rule);
      },
      [&] {
        const TableStyle style = session.table_style();
        PrintRules(*world, style, session.streams.out);
      });
  return absl::OkStatus();
}

void AddPair(CLI::App& command, RuleArguments& pair) {
  command.add_option("A", pair.a, "one of the two")->required();
  command.add_option("B", pair.b, "the other")->required();
}

}  // namespace

void AddRuleCommands(CommandLine& line) {
  const auto allow = std::make_shared<AllowArguments>();
  CLI::App& allowing = AddCommand(line,
                                  {"allow",
                                   "two things to collide: no question sees the pair",
                                   {"cwm allow panda:panda_hand cup --for 5", "cwm allow cup tray",
                                    "cwm allow cup tray --withdraw", "cwm allow crate '*'",
                                    "cwm allow panda:panda_link5 panda:panda_link7 --check"},
                                   kPairMemberForms},
                                  [allow](Session& session) { return Allow(session, *allow); });
  AddPair(allowing, *allow);
  CLI::Option* const for_s =
      allowing.add_option("--for", allow->for_s, "ends by itself after so long (s)")
          ->type_name("SECONDS");
  CLI::Option* const withdraw =
      allowing.add_flag("--withdraw", allow->withdraw, "ends what was said here of the very pair")
          ->excludes(for_s);
  allowing
      .add_flag(
          "--check", allow->check,
          "the contrary: two links of one robot are checked, though its SRDF disables the pair "
          "or they are fixed to each other")
      ->excludes(for_s)
      ->excludes(withdraw);
  AddChangeOptions(allowing, allow->change);

  const auto margin = std::make_shared<MarginArguments>();
  CLI::App& setting = AddCommand(
      line,
      {"margin",
       "of two things, in place of their own and of the question's",
       {"cwm margin panda:panda_hand cup 0", "cwm margin panda '*' 0.02",
        "cwm margin panda '*' --unset"},
       absl::StrCat(kPairMemberForms,
                    "\nWhere several margins apply, that with more names and links counts.")},
      [margin](Session& session) { return SetMargin(session, *margin); });
  AddPair(setting, *margin);
  setting.add_option("METRES", margin->margin_m, "collision means nearer than this");
  setting.add_flag("--unset", margin->unset, "ends what was set of the very pair");
  AddChangeOptions(setting, margin->change);

  AddCommand(line,
             {"rules",
              "of pairs: who may collide with whom, and what margins are kept",
              {"cwm rules", "cwm rules -o ndjson"}},
             [](Session& session) { return List(session); });
}

}  // namespace cwm::cli
