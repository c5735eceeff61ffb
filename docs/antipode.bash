# bash completion for antipode. Options and their words are read from the program's own --help, so
# that they cannot disagree with it.
_antipode() {
	local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} program=${COMP_WORDS[0]}
	local help words
	if [ "$COMP_CWORD" -eq 1 ]; then
		words=$("$program" --help 2>/dev/null | sed -n 's/^  \([a-z]*\) .*/\1/p')
		COMPREPLY=($(compgen -W "$words --help --version" -- "$cur"))
		return
	fi
	help=$("$program" "${COMP_WORDS[1]}" --help 2>/dev/null)
	case $prev in
	--*)
		words=$(printf '%s\n' "$help" | sed -n "s/^  $prev \([a-z0-9|]*|[a-z0-9|]*\) .*/\1/p" | tr '|' ' ')
		if [ -n "$words" ]; then
			COMPREPLY=($(compgen -W "$words" -- "$cur"))
			return
		fi
		;;
	esac
	case $cur in
	-*) COMPREPLY=($(compgen -W "$(printf '%s\n' "$help" | sed -n 's/^  \(--[a-z-]*\).*/\1/p')" -- "$cur")) ;;
	*) COMPREPLY=($(compgen -f -- "$cur")) ;;
	esac
}
complete -o filenames -F _antipode antipode
