#include "pierce/scenes/npy.hpp"

#include <fstream>
#include <xtensor/xadapt.hpp>
#include <xtensor/xarray.hpp>
#include <xtensor/xnpy.hpp>

#include "pierce/core/error.hpp"

namespace pierce::scenes {

FloatArray read_npy(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) throw InputError("cannot open '" + file.string() + "'");
    try {
        const auto array = xt::load_npy<float>(in);
        if (!in || in.peek() != std::ifstream::traits_type::eof())
            throw std::runtime_error("its size does not fit its header");
        return {{array.shape().begin(), array.shape().end()}, {array.begin(), array.end()}};
    } catch (const std::exception& error) {
        throw InputError("cannot read '" + file.string() + "' as float32 .npy: " + error.what());
    }
}

void write_npy(const std::filesystem::path& file, std::span<const std::size_t> shape, std::span<const float> values) {
    const std::vector<std::size_t> dimensions(shape.begin(), shape.end());
    try {
        xt::dump_npy(file.string(), xt::adapt(values.data(), values.size(), xt::no_ownership(), dimensions));
    } catch (const std::exception& error) {
        throw InputError("cannot write '" + file.string() + "': " + error.what());
    }
}

}  // namespace pierce::scenes
