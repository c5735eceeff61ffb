# bash completion for antipode. Options and their words are read from the program's own --help, so
# that they cannot disagree with it.
# Scenes with a name, and words after it. A colon is a word of its own to bash, so what is completed
# after honeycomb: is the symbol.
_antipode_scene() {
	local help=$1 cur=$2 after=$3 names words
	help=$(printf '%s\n' "$help" | sed -n '/^Scenes with a name/,/^and after/p')
	words=$(printf '%s\n' "$help" | sed -n 's/^and after the name: //p' | sed 's/=[A-Z]*/=/g; s/,//g')
	names=$(printf '%s\n' "$help" | sed -n 's/^  honeycomb:P,Q,R of //p')
	if [ "$after" = '' ]; then
		names=$(printf '%s\n' "$help" | sed -n '/^  honeycomb/d; s/^  //p')' honeycomb:'
	fi
	case $after$cur in
	*[0-9],[0-9],[0-9],* | [a-z]*,*) COMPREPLY=($(compgen -P "${cur%,*}," -W "$words" -- "${cur##*,}")) ;;
	*) COMPREPLY=($(compgen -W "$names" -- "$cur")) ;;
	esac
	compopt -o nospace 2>/dev/null
	[ "$after" = '' ] && COMPREPLY+=($(compgen -f -- "$cur"))
}
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
	--scene)
		_antipode_scene "$help" "$cur" ''
		return
		;;
	: | honeycomb)
		if [ "$prev$cur" = honeycomb: ] || [ "$prev${COMP_WORDS[COMP_CWORD - 2]}" = :honeycomb ]; then
			_antipode_scene "$help" "${cur#:}" :
			return
		fi
		;;
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
