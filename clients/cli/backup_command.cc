// cwm backup
#include <memory>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/backup_writer.h"
#include "clients/cli/commands.h"
#include "clients/cli/progress.h"
#include "clients/cli/quantity.h"
#include "clients/cpp/call_error.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

absl::StatusOr<pb::BackUpEnd> Receive(Session& session, BackupWriter& writer) {
  Progress progress(session);
  progress.ShowStage("the server copies its store");
  const client::Connection& connection = session.connection();
  grpc::ClientContext context;
  connection.Prepare(context);
  const auto reader = connection.admin().BackUp(&context, {});
  pb::BackUpResponse piece;
  while (reader->Read(&piece)) {
    if (absl::Status taken = writer.Take(piece); !taken.ok()) {
      context.TryCancel();
      return taken;
    }
    if (piece.has_data()) {
      progress.ShowStage(absl::StrCat(
          "receiving, ", FormatBytes(static_cast<double>(writer.received_bytes())), " so far"));
    }
  }
  if (const grpc::Status status = reader->Finish(); !status.ok()) {
    return client::StatusFromGrpc(status);
  }
  return writer.Finish();
}

absl::Status BackUp(Session& session, const std::string& directory) {
  auto writer = BackupWriter::Create(directory);
  if (!writer.ok()) return writer.status();
  const auto end = Receive(session, *writer);
  if (!end.ok()) return end.status();
  session.Print(*end, [&] {
    session.streams.out << "backed up " << end->file_count()
                        << (end->file_count() == 1 ? " file, " : " files, ")
                        << FormatBytes(static_cast<double>(end->bytes())) << ", to " << directory
                        << "; newest record " << end->sequence() << "\n";
  });
  return absl::OkStatus();
}

}  // namespace

void AddBackupCommand(CommandLine& line) {
  const auto directory = std::make_shared<std::string>();
  CLI::App& command = AddCommand(
      line,
      {"backup",
       "a copy of the server's store, all worlds at one moment, while it goes on",
       {"cwm backup /srv/backups/monday", "cwm restore /srv/backups/monday /var/lib/cwm"},
       "Each file is checked by its SHA-256; DIR has its name only when the copy is complete and "
       "on "
       "the\ndisk. The server keeps its worlds in a store with --store sqlite:PATH."},
      [directory](Session& session) { return BackUp(session, *directory); });
  command.add_option("DIR", *directory, "the directory to make")->required();
}

}  // namespace cwm::cli
