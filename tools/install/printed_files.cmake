# Writes what the program prints of itself below `root` (a share folder): manual pages and completions.
set(pages ${root}/man/man1)
file(MAKE_DIRECTORY ${pages} ${root}/bash-completion/completions ${root}/zsh/vendor-completions ${root}/fish/vendor_completions.d)

function(print file)
  execute_process(COMMAND ${camrig} ${ARGN} OUTPUT_FILE ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

print(${root}/bash-completion/completions/camrig completion bash)
print(${root}/zsh/vendor-completions/_camrig completion zsh)
print(${root}/fish/vendor_completions.d/camrig.fish completion fish)

print(${pages}/camrig.1 manual)
file(STRINGS ${pages}/camrig.1 also REGEX "^\\.BR camrig\\\\-")
foreach(line IN LISTS also)
  string(REGEX REPLACE "^\\.BR camrig\\\\-([^ ]+) .*" "\\1" command "${line}")
  string(REPLACE "\\-" "-" command "${command}")
  print(${pages}/camrig-${command}.1 manual ${command})
endforeach()
file(GLOB all ${pages}/camrig*.1)
execute_process(COMMAND gzip -9nf ${all} COMMAND_ERROR_IS_FATAL ANY)
