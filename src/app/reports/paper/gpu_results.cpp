#include "app/reports/paper/gpu_results.hpp"

#include <algorithm>

#include "core/base/whole_file.hpp"
#include "scenes/detect/method.hpp"

namespace pierce::app {

namespace fs = std::filesystem;

std::optional<Table> on_gpu(const PaperReportOptions& options, Page& page, const std::string& name,
                            const std::function<Table(const KeepTable&)>& measure) {
    if (scenes::cuda_can_run()) {
        const KeepTable keep = [&](const Table& table) { page.csv(table, name); };
        Table table = measure(keep);
        keep(table);
        return table;
    }
    const std::string file = name + ".csv";
    if (options.gpu_results.empty()) {
        page.line(
            "\n*Not measured: this part needs a GPU. `--gpu-results DIR` takes it from a folder "
            "that `pierce report paper` wrote on a machine with one.*\n");
        return std::nullopt;
    }
    const fs::path from = options.gpu_results / file;
    if (!fs::exists(from)) {
        page.line(
            "\n*Not measured: this part needs a GPU, and `{}` is not in the folder of "
            "results.*\n",
            file);
        return std::nullopt;
    }
    Table table = Table::read_csv(from);
    // Names in CSV files have no commas.
    for (std::string& label : table.labels) std::ranges::replace(label, ';', ',');
    if (!fs::exists(page.folder() / file) || !fs::equivalent(from, page.folder() / file)) {
        WholeFile copy(page.folder() / file);
        fs::copy_file(from, copy.part(), fs::copy_options::overwrite_existing);
        copy.keep();
    }
    page.line("\n*Measured elsewhere, and merged from a folder of results:* `{}`\n",
              table.made_with);
    return table;
}

}  // namespace pierce::app
