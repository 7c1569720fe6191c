// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/command.h"
#include "apps/run/fault.h"
#include "apps/run/graph_picture.h"
#include "apps/run/pictures.h"
#include "apps/run/progress.h"
#include "apps/run/stage_clock.h"
#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/graph/robust_relax.h"
#include "core/graph/tree_descent.h"
#include "core/io/csv.h"
#include "core/io/file.h"
#include "core/io/g2o.h"
#include "core/io/graph_file.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct RelaxArguments {
  std::string graph;
  std::string out;
  std::string start = "file";
  std::string method = "newton";
  bool robust = false;
  bool quiet = false;
};

// Refused before anything is done: what cannot be written in the end.
fs::path checked_out(const RelaxArguments& args) {
  fs::path out = args.out;
  std::error_code ignored;
  if (out.extension() != ".g2o" || out.stem().empty()) {
    throw ConfigError("--out " + args.out + ": must name a file that ends in .g2o");
  }
  if (fs::equivalent(out, args.graph, ignored)) {
    throw ConfigError("--out " + args.out + ": is the graph itself; name another file");
  }
  if (fs::is_directory(out, ignored)) {
    throw ConfigError("--out " + args.out + ": is a folder; name a file");
  }
  const fs::path folder = out.has_parent_path() ? out.parent_path() : fs::path(".");
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored)) {
    throw ConfigError("--out " + args.out + ": " + folder.string() + " is not a folder");
  }
  for (const char* ending : {".g2o", ".png", ".metrics.json", ".rejected.csv"}) {
    const fs::path beside = fs::path(out).replace_extension(ending);
    if (fs::exists(beside, ignored)) {
      throw ConfigError("--out " + args.out + ": " + beside.string() +
                        " is there already; remove it or name another file");
    }
  }
  return out;
}

RobustReport solve(const RelaxArguments& args, const GraphFile& file, PoseGraph& graph) {
  RobustReport report;
  report.kept.assign(graph.edges.size(), true);
  ProgressLine line(args.quiet);
  const auto steps = [&line](const RelaxReport& now) {
    if (line.due()) {
      line.show(fmt::format("step {}: chi2 {:.6g}", now.iterations + 1, now.chi2_end));
    }
  };
  if (args.robust) {
    if (const std::optional<int> gap = odometry_gap(graph)) {
      throw ConfigError(fmt::format(
          "{}: no edge joins vertices {} and {}; --robust judges closures by odometry, which must "
          "join each vertex to the next",
          args.graph, file.ids[*gap - 1], file.ids[*gap]));
    }
    const auto rings = [&line](double done) {
      if (line.due()) {
        line.show(share_line("closures", done, line.wall_s()));
      }
    };
    report = relax_robustly(graph, rings, steps);
  } else if (args.method == "toro") {
    report.relax = relax_by_tree(graph, {}, steps);
  } else {
    report.relax = relax(graph, RelaxStart::kCurrent, steps);
  }
  return report;
}

Json figures_of(const RelaxArguments& args, const GraphFile& file, const RobustReport& report,
                double solve_s) {
  Json chi2;
  if (file.poses_given) {
    chi2["start"] = report.relax.chi2_start;
  }
  chi2["end"] = report.relax.chi2_end;
  const ProcessUse use = process_use();
  Json figures{
      {"schema", "panoptes.metrics/1"},
      {"command", "relax"},
      {"version", PANOPTES_VERSION},
      {"outcome", report.relax.converged || args.method == "toro" ? "completed" : "failed"},
      {"method", args.method},
      {"start", args.start},
      {"chi2", chi2},
      {"nodes", file.graph.T_map_node.size()},
      {"edges", file.graph.edges.size()},
      {"closures", std::count_if(file.graph.edges.begin(), file.graph.edges.end(),
                                 [](const GraphEdge& edge) { return edge.closure; })},
      {"edges_rejected", report.rejected},
      {"iterations", report.relax.iterations}};
  if (args.robust) {
    figures["noise_scale"] = report.noise_scale;
  }
  figures["solve_s"] = solve_s;
  figures["wall_s"] = use.wall_s;
  figures["cpu_s"] = use.cpu_s;
  figures["peak_memory_mb"] = use.peak_memory_mb;
  return figures;
}

PoseGraph kept_of(PoseGraph graph, const std::vector<bool>& kept) {
  std::vector<GraphEdge> edges;
  for (std::size_t e = 0; e < kept.size(); ++e) {
    if (kept[e]) {
      edges.push_back(graph.edges[e]);
    }
  }
  graph.edges = std::move(edges);
  return graph;
}

// Names the closures that were left out: the first few here, all of them in a table.
void name_rejected(const GraphFile& file, const std::vector<bool>& kept, const fs::path& path) {
  constexpr int kNamed = 10;
  CsvWriter table(path, {"from", "to"});
  int count = 0;
  for (std::size_t e = 0; e < kept.size(); ++e) {
    if (kept[e]) {
      continue;
    }
    const int from = file.ids[file.graph.edges[e].from];
    const int to = file.ids[file.graph.edges[e].to];
    table << from << to;
    table.end_row();
    if (++count <= kNamed) {
      std::printf("rejected: %d -> %d\n", from, to);
    }
  }
  table.finish();
  if (count > kNamed) {
    std::printf("rejected: %d more, in %s\n", count - kNamed, path.c_str());
  }
}

// Relaxes a pose graph, and tells how well its edges agree before and after.
int relax_file(const RelaxArguments& args) {
  if (args.robust && args.method == "toro") {
    throw ConfigError("--robust: goes with --method newton alone");
  }
  const fs::path out = checked_out(args);
  const GraphFile file = read_graph(args.graph);
  for (const std::string& remark : file.remarks) {
    std::fprintf(stderr, "%s\n", remark.c_str());
  }
  PoseGraph graph = file.graph;
  if (args.start == "odometry") {
    dead_reckon(graph);
  }
  GraphPicture picture{graph, {}, {}, {}};
  const double from_s = process_use().cpu_s;
  const RobustReport report = solve(args, file, graph);
  const double solve_s = process_use().cpu_s - from_s;
  Json figures = figures_of(args, file, report, solve_s);
  picture.T_map_node_after = graph.T_map_node;
  picture.kept = report.kept;
  picture.title =
      fmt::format("{}: chi2 {:.6g} to {:.6g}{}", fs::path(args.graph).filename().string(),
                  report.relax.chi2_start, report.relax.chi2_end,
                  args.robust ? fmt::format(", {} rejected", report.rejected) : "");
  if (out.has_parent_path()) {
    fs::create_directories(out.parent_path());
  }
  std::printf("%s\n", picture.title.c_str());
  Faults faults;
  faults.attempt([&] { write_g2o(out, kept_of(graph, report.kept), file.ids); });
  if (args.robust) {
    faults.attempt([&] {
      name_rejected(file, report.kept, fs::path(out).replace_extension(".rejected.csv"));
    });
  }
  faults.attempt(
      [&] { write_file(fs::path(out).replace_extension(".png"), png(draw_graph(picture))); });
  if (!faults.none()) {
    figures["outcome"] = "failed";
    figures["fault"] = as_utf8(faults.text());
  }
  faults.attempt([&] {
    write_file(fs::path(out).replace_extension(".metrics.json"), figures.dump(2) + "\n");
  });
  if (!faults.none()) {
    return faults.status();
  }
  if (figures["outcome"] == "failed") {
    std::fprintf(stderr, "%s: did not settle within %d steps%s\n", args.graph.c_str(),
                 report.relax.iterations,
                 args.robust ? "" : "; closures may be false, which --robust leaves out");
  }
  std::printf("%s\n", out.c_str());
  return figures["outcome"] == "completed" ? 0 : 1;
}

}  // namespace

void add_relax(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<RelaxArguments>();
  CLI::App* sub = app.add_subcommand("relax", "Where do the edges of a pose graph agree best?");
  sub->add_option("GRAPH", args->graph, "a 2-D pose graph of g2o or TORO")
      ->required()
      ->type_name("FILE");
  sub->add_option("--out", args->out,
                  "the relaxed graph; figures and a picture lie beside it as .metrics.json and "
                  ".png, with --robust what was rejected as .rejected.csv")
      ->required()
      ->type_name("FILE.g2o");
  sub->add_option("--start", args->start, "the file's poses, or dead reckoned ones (file)")
      ->type_name("START")
      ->check(CLI::IsMember({"file", "odometry"}));
  sub->add_option("--method", args->method,
                  "least squares, or the tree descent of TORO, which only comes near (newton)")
      ->type_name("METHOD")
      ->check(CLI::IsMember({"newton", "toro"}));
  sub->add_flag("--robust", args->robust,
                "find the closures that are false and leave them out; needs odometry between each "
                "two vertices that follow one another");
  sub->add_flag("--quiet", args->quiet, "no progress");
  sub->footer(
      "Example: panoptes relax runs/office/graph.g2o --robust --out runs/office-relaxed.g2o\n"
      "         panoptes relax manhattan.graph --start odometry --method toro --out m.g2o");
  sub->callback([args, &chosen] { chosen = [args] { return relax_file(*args); }; });
}

}  // namespace panoptes
