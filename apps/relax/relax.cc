// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/command/command.h"
#include "apps/draw/pictures.h"
#include "apps/process/fault.h"
#include "apps/process/progress.h"
#include "apps/process/stage_clock.h"
#include "apps/relax/graph_picture.h"
#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/graph/relax_starts.h"
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
  double time_limit_s = 300;
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

// On the wall's clock. A step that would end after the limit is not begun: one alone may take
// minutes where closures join everything with everything.
class TimeLimit {
 public:
  explicit TimeLimit(double limit_s) : limit_s_(limit_s), from_s_(process_use().wall_s) {}

  bool passed(double multiplications) {
    const double now_s = process_use().wall_s - from_s_;
    if (last_multiplications_ > kManyMultiplications) {
      s_per_multiplication_ = (now_s - last_s_) / last_multiplications_;
    }
    last_multiplications_ = multiplications;
    last_s_ = now_s;
    passed_ = passed_ || now_s + s_per_multiplication_ * multiplications > limit_s_;
    return passed_;
  }
  bool passed() const { return passed_; }

 private:
  static constexpr double kManyMultiplications = 1e7;  // that take longer than all beside them

  double limit_s_;
  double from_s_;
  double s_per_multiplication_ = 1e-9;  // of a slow computer; then as the last step was
  double last_multiplications_ = 0;
  double last_s_ = 0;
  bool passed_ = false;
};

struct Solution {
  RobustReport report;
  std::vector<StartReport> starts;
  std::string best_start;
  Plausibility plausibility;
  bool out_of_time = false;

  // than rounding makes of a graph that is exact
  bool got_worse() const {
    constexpr double kRounding = 1e-9;
    return !(report.relax.chi2_end <= std::max(report.relax.chi2_start, kRounding));
  }
  bool trustworthy(const RelaxArguments& args) const {
    return !args.robust || plausibility.plausible;
  }
  bool good(const RelaxArguments& args) const {
    return args.method == "toro" ? !got_worse() && !out_of_time
                                 : report.relax.converged && trustworthy(args);
  }
};

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

void solve_robustly(const RelaxArguments& args, const GraphFile& file, ProgressLine& line,
                    const RelaxProgress& steps, const RelaxStop& stop, PoseGraph& graph,
                    Solution& solution) {
  if (const std::optional<int> gap = odometry_gap(graph)) {
    throw ConfigError(fmt::format(
        "{}: no edge joins vertices {} and {}; --robust judges closures by odometry, which must "
        "join each vertex to the next",
        args.graph, file.ids[*gap - 1], file.ids[*gap]));
  }
  const auto cycles = [&line](double done) {
    if (line.due()) {
      line.show(share_line("closures", done, line.wall_s()));
    }
  };
  solution.report = relax_robustly(graph, cycles, steps, stop);
}

Solution solve(const RelaxArguments& args, const GraphFile& file, PoseGraph& graph) {
  Solution solution;
  solution.report.kept.assign(graph.edges.size(), true);
  ProgressLine line(args.quiet);
  const auto steps = [&line](const RelaxReport& now) {
    if (line.due()) {
      line.show(fmt::format("step {}: chi2 {:.6g}", now.iterations + 1, now.chi2_end));
    }
  };
  TimeLimit limit(args.time_limit_s);
  const auto stop = [&limit](double multiplications) { return limit.passed(multiplications); };
  if (args.robust) {
    solve_robustly(args, file, line, steps, stop, graph, solution);
  } else if (args.method == "toro") {
    solution.report.relax = relax_by_tree(graph, {}, steps, stop);
  } else {
    StartsReport report = relax_from_every_start(graph, steps, stop);
    for (StartReport& start : report.starts) {
      start.name = start.name == "given" ? args.start : start.name;
    }
    solution.report.relax = report.relax;
    solution.starts = std::move(report.starts);
    solution.best_start = report.best == "given" ? args.start : report.best;
  }
  solution.out_of_time = limit.passed();
  solution.plausibility = plausibility(kept_of(graph, solution.report.kept));
  return solution;
}

Json starts_of(const Solution& solution) {
  Json starts;
  for (const StartReport& start : solution.starts) {
    starts[start.name] = {
        {"chi2", {{"start", start.relax.chi2_start}, {"end", start.relax.chi2_end}}},
        {"iterations", start.relax.iterations},
        {"converged", start.relax.converged}};
  }
  return starts;
}

Json figures_of(const RelaxArguments& args, const GraphFile& file, const Solution& solution,
                double solve_s) {
  const RobustReport& report = solution.report;
  Json chi2;
  if (file.poses_given) {
    chi2["start"] = report.relax.chi2_start;
  }
  chi2["end"] = report.relax.chi2_end;
  const ProcessUse use = process_use();
  Json figures{{"schema", "panoptes.metrics/1"},
               {"command", "relax"},
               {"version", PANOPTES_VERSION},
               {"outcome", solution.good(args) ? "completed" : "failed"},
               {"method", args.method},
               {"start", args.start},
               {"chi2", chi2},
               {"freedom", solution.plausibility.degrees_of_freedom},
               {"nodes", file.graph.T_map_node.size()},
               {"edges", file.graph.edges.size()},
               {"closures", std::count_if(file.graph.edges.begin(), file.graph.edges.end(),
                                          [](const GraphEdge& edge) { return edge.closure; })},
               {"edges_rejected", report.rejected},
               {"iterations", report.relax.iterations}};
  if (solution.out_of_time) {
    figures["end_reason"] = "time_limit";
  }
  if (!solution.starts.empty()) {
    figures["best_start"] = solution.best_start;
    figures["starts"] = starts_of(solution);
  }
  if (args.robust) {
    figures["noise_scale"] = report.noise_scale;
    figures["trustworthy"] = solution.good(args);
    figures["edges_disagreeing"] = solution.plausibility.disagreeing.size();
  }
  figures["solve_s"] = solve_s;
  figures["wall_s"] = use.wall_s;
  figures["cpu_s"] = use.cpu_s;
  figures["peak_memory_mb"] = use.peak_memory_mb;
  return figures;
}

// Closures that start near each other and end near each other: `12..20 -> 512..520 (9)`, the
// largest group first.
std::string groups_of(const PoseGraph& kept, const std::vector<int>& closures,
                      const std::vector<int>& ids) {
  constexpr int kNear = 20;  // nodes
  constexpr std::size_t kNamed = 5;
  struct Group {
    std::array<int, 2> from, to;  // first and last
    int count;
  };
  std::vector<Group> groups;
  for (const int e : closures) {
    const GraphEdge& edge = kept.edges[e];
    const auto near = [](const std::array<int, 2>& span, int node) {
      return node >= span[0] - kNear && node <= span[1] + kNear;
    };
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
      return near(g.from, edge.from) && near(g.to, edge.to);
    });
    if (group == groups.end()) {
      groups.push_back({{edge.from, edge.from}, {edge.to, edge.to}, 1});
    } else {
      group->from = {std::min(group->from[0], edge.from), std::max(group->from[1], edge.from)};
      group->to = {std::min(group->to[0], edge.to), std::max(group->to[1], edge.to)};
      ++group->count;
    }
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const Group& a, const Group& b) { return a.count > b.count; });
  std::string text;
  for (std::size_t g = 0; g < std::min(kNamed, groups.size()); ++g) {
    text += fmt::format("{}{}..{} -> {}..{} ({})", g == 0 ? "" : ", ", ids[groups[g].from[0]],
                        ids[groups[g].from[1]], ids[groups[g].to[0]], ids[groups[g].to[1]],
                        groups[g].count);
  }
  return text + (groups.size() > kNamed ? fmt::format(" and {} more", groups.size() - kNamed) : "");
}

// What keeps the result from being good, on stderr.
void say_what_is_wrong(const RelaxArguments& args, const GraphFile& file, const PoseGraph& kept,
                       const Solution& solution) {
  const RelaxReport& relax = solution.report.relax;
  const Plausibility& noise = solution.plausibility;
  const auto say = [&args](const std::string& what) {
    std::fprintf(stderr, "%s: %s\n", args.graph.c_str(), what.c_str());
  };
  if (solution.out_of_time) {
    say(
        fmt::format("not done within {:g} s; what is written is the best so far (--time-limit "
                    "gives it longer)",
                    args.time_limit_s));
  } else if (args.method == "toro") {
    if (solution.got_worse()) {
      say(fmt::format(
          "the tree descent made it worse: chi2 {:.6g} to {:.6g}; --method newton never "
          "does",
          relax.chi2_start, relax.chi2_end));
    }
  } else if (!relax.converged) {
    say(fmt::format("did not settle within {} steps{}", relax.iterations,
                    args.robust ? "" : "; closures may be false, which --robust leaves out"));
  }
  if (!noise.plausible) {
    say(fmt::format(
        "{}chi2 is {:.3g} per degree of freedom, and errors twice those stated give "
        "{:.3g} at most",
        args.robust ? "not to be trusted: " : "", relax.chi2_end / noise.degrees_of_freedom,
        noise.chi2_most / noise.degrees_of_freedom));
    if (!noise.disagreeing.empty()) {
      say(fmt::format("{} closures {} disagree with the rest by more than such errors: {}{}",
                      noise.disagreeing.size(), args.robust ? "kept" : "given",
                      groups_of(kept, noise.disagreeing, file.ids),
                      args.robust ? "; false ones that agree with each other are kept"
                                  : "; --robust leaves false ones out"));
    }
  }
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
  if (!std::isfinite(args.time_limit_s) || args.time_limit_s <= 0) {
    throw ConfigError(fmt::format("--time-limit: must be a number of seconds above 0, got {:g}",
                                  args.time_limit_s));
  }
  if (args.robust && args.method == "toro") {
    throw ConfigError("--robust: goes with --method newton alone");
  }
  const fs::path out = checked_out(args);
  const GraphFile file = read_graph(args.graph);
  for (const std::string& warning : file.warnings) {
    std::fprintf(stderr, "%s\n", warning.c_str());
  }
  PoseGraph graph = file.graph;
  if (args.start == "odometry") {
    dead_reckon(graph);
  }
  GraphPicture picture{graph, {}, {}, {}};
  const double from_s = process_use().cpu_s;
  const Solution solution = solve(args, file, graph);
  const RobustReport& report = solution.report;
  const double solve_s = process_use().cpu_s - from_s;
  Json figures = figures_of(args, file, solution, solve_s);
  picture.T_map_node_after = graph.T_map_node;
  picture.kept = report.kept;
  picture.title =
      fmt::format("{}: chi2 {:.6g} to {:.6g}{}", fs::path(args.graph).filename().string(),
                  report.relax.chi2_start, report.relax.chi2_end,
                  args.robust ? fmt::format(", {} rejected", report.rejected) : "");
  if (out.has_parent_path()) {
    fs::create_directories(out.parent_path());
  }
  const PoseGraph kept = kept_of(graph, report.kept);
  std::printf("%s\n", picture.title.c_str());
  for (const StartReport& start : solution.starts) {
    std::printf("from %s: chi2 %.6g to %.6g%s%s\n", start.name.c_str(), start.relax.chi2_start,
                start.relax.chi2_end, start.relax.converged ? "" : ", not settled",
                start.name == solution.best_start ? ", kept" : "");
  }
  say_what_is_wrong(args, file, kept, solution);
  Faults faults;
  faults.attempt([&] { write_g2o(out, kept, file.ids); });
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
  std::printf("%s\n", out.c_str());
  return solution.good(args) ? 0 : 1;
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
  sub->add_option("--start", args->start,
                  "the file's poses, or dead reckoned ones (file); least squares try these and "
                  "others, and keep the least")
      ->type_name("START")
      ->check(CLI::IsMember({"file", "odometry"}));
  sub->add_option("--method", args->method,
                  "least squares, or the tree descent of TORO, which only comes near (newton)")
      ->type_name("METHOD")
      ->check(CLI::IsMember({"newton", "toro"}));
  sub->add_flag("--robust", args->robust,
                "find the closures that are false and leave them out; needs odometry between each "
                "two vertices that follow one another");
  sub->add_option("--time-limit", args->time_limit_s,
                  "after so many seconds the best so far is written, with status 1 (300)")
      ->type_name("S");
  sub->add_flag("--quiet", args->quiet, "no progress");
  sub->footer(
      "Example: panoptes relax runs/office/graph.g2o --robust --out runs/office-relaxed.g2o\n"
      "         panoptes relax manhattan.graph --start odometry --method toro --out m.g2o");
  sub->callback([args, &chosen] { chosen = [args] { return relax_file(*args); }; });
}

}  // namespace panoptes
