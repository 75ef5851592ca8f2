#include "manual/manual_page.h"

#include <cctype>
#include <sstream>
#include <utility>

namespace cwm::manual {
namespace {

// The text with the characters escaped that roff would interpret: minus signs stay copyable, and no
// line becomes a request.
std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      const bool starts_line = escaped.empty() || escaped.back() == '\n';
      if (starts_line && (c == '.' || c == '\'')) escaped += "\\&";
      escaped += c;
    }
  }
  return escaped;
}

std::string UpperCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

bool StartsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

struct Description {
  std::string summary;
  std::string text;      // roff
  std::string examples;  // roff
  std::string exit_codes;
};

std::string WithoutIndent(const std::string& line) {
  const std::size_t first = line.find_first_not_of(' ');
  return first == std::string::npos ? "" : line.substr(first);
}

// Reads a description line by line and tracks the part of it that each line belongs to.
class DescriptionReader {
 public:
  Description Read(const std::string& description) {
    std::istringstream lines(description);
    std::getline(lines, read_.summary);
    for (std::string line; std::getline(lines, line);) Take(line);
    EndVerbatim();
    return std::move(read_);
  }

 private:
  void Take(const std::string& line) {
    if (line.empty()) {
      EndVerbatim();
      in_exit_codes_ = in_examples_ = false;
      at_paragraph_ = true;
    } else if (line == "Examples:") {
      in_examples_ = true;
    } else if (const std::size_t at = line.find("Exit codes: "); at != std::string::npos) {
      if (at > 0) TakeText(line.substr(0, at));
      in_exit_codes_ = true;
      read_.exit_codes = Escape(line.substr(at + 12)) + "\n";
    } else if (in_exit_codes_) {
      read_.exit_codes += Escape(line) + "\n";
    } else if (line.front() == ' ') {
      TakeVerbatim(WithoutIndent(line));
    } else {
      in_examples_ = false;
      TakeText(line);
    }
  }
  void TakeText(const std::string& line) {
    EndVerbatim();
    if (at_paragraph_ && !read_.text.empty()) read_.text += ".PP\n";
    at_paragraph_ = false;
    read_.text += Escape(line) + "\n";
  }
  void TakeVerbatim(const std::string& line) {
    std::string& part = in_examples_ ? read_.examples : read_.text;
    if (open_ != &part) {
      EndVerbatim();
      part += ".nf\n";
      open_ = &part;
    }
    part += Escape(line) + "\n";
  }
  void EndVerbatim() {
    if (open_ != nullptr) *open_ += ".fi\n";
    open_ = nullptr;
  }

  Description read_;
  bool in_examples_ = false, in_exit_codes_ = false, at_paragraph_ = true;
  std::string* open_ = nullptr;  // the part whose lines are copied as they are
};

// The entry of one option: its names in bold, its value in italics.
std::string OptionEntry(const CLI::Option& option) {
  std::string entry = ".TP\n\\fB" + Escape(option.get_name(option.get_positional(), true)) + "\\fR";
  if (option.get_expected_max() > 0 && !option.get_type_name().empty()) {
    entry += " \\fI" + Escape(option.get_type_name()) + "\\fR";
  }
  entry += "\n" + Escape(option.get_description());
  if (!option.get_default_str().empty()) {
    entry += " (default: " + Escape(option.get_default_str()) + ")";
  }
  return entry + "\n";
}

// The entries of all options; empty if there are none. A command's own help option is left out,
// because every program has it.
std::string Options(const CLI::App& app, bool with_help) {
  std::string entries;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty() || (option == app.get_help_ptr() && !with_help)) continue;
    entries += OptionEntry(*option);
  }
  return entries;
}

std::vector<const CLI::App*> ShownCommands(const CLI::App& app) {
  std::vector<const CLI::App*> shown;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (!command->get_group().empty()) shown.push_back(command);
  }
  return shown;
}

std::string Commands(const CLI::App& app, const std::string& before) {
  std::string sections;
  for (const CLI::App* command : ShownCommands(app)) {
    const std::string name = before + command->get_name();
    const Description told = DescriptionReader().Read(command->get_description());
    sections += ".SS " + Escape(name) + "\n" + Escape(told.summary) + "\n";
    if (!told.text.empty()) sections += ".PP\n" + told.text;
    sections += Options(*command, false);
    if (!told.examples.empty())
      sections += ".PP\nExamples:\n.PP\n.RS 4\n" + told.examples + ".RE\n";
    sections += Commands(*command, name + " ");
  }
  return sections;
}

std::string Section(const std::string& title, const std::string& body) {
  return body.empty() ? "" : ".SH " + title + "\n" + body;
}

std::string Synopsis(const CLI::App& app) {
  std::string synopsis = "\\fB" + Escape(app.get_name()) + "\\fR [\\fIOPTIONS\\fR]";
  if (!ShownCommands(app).empty()) synopsis += " \\fICOMMAND\\fR ...";
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_positional()) continue;
    const std::string name = "\\fI" + Escape(option->get_name(true)) + "\\fR";
    synopsis += option->get_required() ? " " + name : " [" + name + "]";
  }
  return synopsis + "\n";
}

std::string Environment(const Facts& facts) {
  std::string entries;
  for (const Variable& each : facts.environment) {
    entries += ".TP\n\\fB" + Escape(each.name) + "\\fR\n" + Escape(each.meaning) + "\n";
  }
  return entries;
}

}  // namespace

std::string ManualPage(const CLI::App& app, const Facts& facts) {
  const std::string& name = app.get_name();
  std::string description = app.get_description();
  if (StartsWith(description, name + ": ")) description.erase(0, name.size() + 2);
  if (!app.get_footer().empty()) description += "\n\n" + app.get_footer();
  const Description told = DescriptionReader().Read(description);
  return ".TH " + Escape(UpperCase(name)) + " " + facts.section + " \"\" \"cwm " + facts.version +
         "\"\n.SH NAME\n" + Escape(name) + " \\- " + Escape(told.summary) + "\n" +
         Section("SYNOPSIS", Synopsis(app)) + Section("DESCRIPTION", told.text) +
         Section("OPTIONS", Options(app, true)) + Section("COMMANDS", Commands(app, "")) +
         Section("EXIT STATUS", told.exit_codes) + Section("ENVIRONMENT", Environment(facts)) +
         Section("EXAMPLES", told.examples);
}

void AddManualPage(CLI::App& app, Facts facts) {
  app.add_flag_callback("--manual-page",
                        [&app, facts = std::move(facts)] {
                          // CLI11 prints a version by this exception, so a caller that handles it
                          // handles this one.
                          throw CLI::CallForVersion(ManualPage(app, facts), 0);
                        })
      ->group("");
}

}  // namespace cwm::manual
