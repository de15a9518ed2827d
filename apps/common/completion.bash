# bash completion for @command@
_@command@() {
  local current=${COMP_WORDS[COMP_CWORD]} flag='' words='' before=''
  if [[ $current == --*=* ]]; then
    flag=${current%%=*} before=$flag= current=${current#*=}
  elif [[ $current == = ]]; then
    flag=${COMP_WORDS[COMP_CWORD-1]} current=''
  elif ((COMP_CWORD > 1)) && [[ ${COMP_WORDS[COMP_CWORD-1]} == = ]]; then
    flag=${COMP_WORDS[COMP_CWORD-2]}
  fi
  compopt +o nospace 2>/dev/null
  case $flag in
    '') words=@flags@ ;;
@cases@  esac
  if [[ -n $words ]]; then
    mapfile -t COMPREPLY < <(compgen -P "$before" -W "$words" -- "$current")
    [[ ${COMPREPLY[0]:-} == *= ]] && compopt -o nospace 2>/dev/null
  else
    if [[ $current == *,* ]]; then
      before+=${current%,*}, current=${current##*,}
    fi
    mapfile -t COMPREPLY < <(compgen -P "$before" -f -- "$current")
    compopt -o filenames 2>/dev/null
  fi
}
complete -F _@command@ @command@
