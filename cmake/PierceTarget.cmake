# pierce_library(NAME SOURCES...): a library target pierce_NAME, known as pierce::NAME here and when installed. Its public
# headers, if it has any, lie in include/ as they are installed.
function(pierce_library name)
    add_library(pierce_${name} ${ARGN})
    add_library(pierce::${name} ALIAS pierce_${name})
    set_target_properties(pierce_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
    if(IS_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/include)
        target_include_directories(pierce_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
                                                         $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
    endif()
    pierce_options(pierce_${name})
endfunction()

# The compile options of everything in this project, which sees all of its headers.
function(pierce_options target)
    target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
    get_target_property(type ${target} TYPE)
    target_compile_features(${target} PUBLIC cxx_std_20)
    # No errno from sqrt and no traps: neither changes a result, both stand in the way of vector instructions.
    # Fused multiply-adds differ between machines and break the antisymmetry of edge functions.
    target_compile_options(${target} PUBLIC
        "$<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off;-fno-math-errno;-fno-trapping-math>")
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wpedantic -Wshadow -Wconversion
                                             $<$<BOOL:${PIERCE_WERROR}>:-Werror>>)
    # Clang's -Wconversion says more than GCC's: of indices that change from signed to unsigned.
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,Clang>:-Wno-sign-conversion>)
    foreach(option PIERCE_CHECKED_VIEWS PIERCE_FUSED_PRODUCTS)
        if(${option})
            target_compile_definitions(${target} PUBLIC ${option})
        endif()
    endforeach()
    # The same rules on the device: no fused multiply-adds, division and square root rounded as IEEE 754 says.
    target_compile_options(${target} PRIVATE
        "$<$<COMPILE_LANGUAGE:CUDA>:-std=c++20;--expt-relaxed-constexpr;-fmad=false;-prec-div=true;-prec-sqrt=true;-ftz=false>"
        "$<$<COMPILE_LANGUAGE:CUDA>:-Xcompiler=-Wall,-Wextra,-ffp-contract=off>"
        $<$<AND:$<COMPILE_LANGUAGE:CUDA>,$<BOOL:${PIERCE_WERROR}>>:-Werror=all-warnings>)
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
        # GCC 12 warns about its own std::string (gcc.gnu.org/bugzilla 105651).
        target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Wno-restrict>)
    endif()
endfunction()
