#include "support/meeting_queries.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace pierce::test {
namespace {

/// The whole numbers of a line.
std::vector<mpz_class> numbers_of(const std::string& line) {
    std::vector<mpz_class> numbers;
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) {
        mpz_class number;
        if (!cell.empty() && cell.back() == '\r') cell.pop_back();
        if (number.set_str(cell, 10) != 0) return {};
        numbers.push_back(number);
    }
    return numbers;
}

}  // namespace

std::vector<MeetingQuery> read_meeting_queries(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw std::runtime_error(file.string() + ": cannot be read");
    std::vector<MeetingQuery> queries;
    std::size_t row = 0;
    for (std::string line; std::getline(in, line); ++row) {
        const std::string where = file.string() + ":" + std::to_string(row + 1) + ": ";
        const std::vector<mpz_class> numbers = numbers_of(line);
        if (numbers.size() != 7) throw std::runtime_error(where + "not seven whole numbers");
        if (row % 8 == 0) queries.push_back({{}, numbers[6] != 0});
        if (queries.back().meets != (numbers[6] != 0))
            throw std::runtime_error(where + "another answer than the line before");
        truth::ExactMovingPoint& corner = queries.back().corners[row % 4];
        for (std::size_t k = 0; k < 3; ++k) {
            if (numbers[2 * k + 1] == 0) throw std::runtime_error(where + "a denominator is zero");
            mpq_class value(numbers[2 * k], numbers[2 * k + 1]);
            value.canonicalize();
            (row % 8 < 4 ? corner.start : corner.end)[k] = value;
        }
    }
    if (row % 8 != 0)
        throw std::runtime_error(file.string() + ": the last query has less than eight lines");
    return queries;
}

std::vector<std::filesystem::path> meeting_query_files(const std::filesystem::path& folder,
                                                       const std::string& name) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.path().extension() == ".csv" && entry.path().parent_path().filename() == name)
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

RoundedCorners rounded(const ExactCorners& corners) {
    RoundedCorners result;
    for (std::size_t i = 0; i < 4; ++i)
        for (int k = 0; k < 3; ++k) {
            const auto axis = static_cast<std::size_t>(k);
            result.corners[i].start[k] = corners[i].start[axis].get_d();
            result.corners[i].end[k] = corners[i].end[axis].get_d();
            result.exact &= result.corners[i].start[k] == corners[i].start[axis];
            result.exact &= result.corners[i].end[k] == corners[i].end[axis];
        }
    return result;
}

}  // namespace pierce::test
