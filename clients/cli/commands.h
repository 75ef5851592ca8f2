// All commands in the order of the help, except that of report_command.h.
#pragma once

#include "clients/cli/command.h"

namespace cwm::cli {

void AddStatusCommands(CommandLine& line);     // status, info
void AddSegmentCommand(CommandLine& line);     // segment
void AddIngestCommand(CommandLine& line);      // ingest
void AddStreamCommand(CommandLine& line);      // stream
void AddSensorsCommand(CommandLine& line);     // sensors, sensors set
void AddObjectCommands(CommandLine& line);     // objects, get
void AddPutCommand(CommandLine& line);         // put
void AddChangeCommands(CommandLine& line);     // move, remove
void AddAttachCommands(CommandLine& line);     // attach, detach
void AddRuleCommands(CommandLine& line);       // allow, margin, rules
void AddImportCommand(CommandLine& line);      // import
void AddExportCommand(CommandLine& line);      // export
void AddRobotCommands(CommandLine& line);      // robot load, list, get, remove
void AddPairCommands(CommandLine& line);       // distance, contacts
void AddCheckCommand(CommandLine& line);       // check
void AddMotionCommand(CommandLine& line);      // motion
void AddSolveCommand(CommandLine& line);       // solve
void AddRayCommand(CommandLine& line);         // ray
void AddSampleCommand(CommandLine& line);      // sample
void AddWatchCommand(CommandLine& line);       // watch
void AddBackupCommand(CommandLine& line);      // backup
void AddStoreCommands(CommandLine& line);      // restore, store check, stat
void AddBenchCommand(CommandLine& line);       // bench
void AddCallCommand(CommandLine& line);        // call
void AddCompletionCommand(CommandLine& line);  // completion

}  // namespace cwm::cli
